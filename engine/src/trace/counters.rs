//! What a frame counted: rays, what did not fit, what was brought or built, and what leaving something out has saved.

use crate::frame::Skip;

/// Rays of the last picture by kind, and what did not fit. On a GPU those that are not asked for
/// ([`crate::frame::TraceSettings::count_rays`]) are 0.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counters {
    /// Camera rays.
    pub primary_rays: u64,
    /// Mirrored rays.
    pub reflected_rays: u64,
    /// Refracted and straight-through rays.
    pub refracted_rays: u64,
    /// Shadow rays.
    pub shadow_rays: u64,
    /// Entries into a medium that the list of media had no room for.
    pub media_overflows: u64,
    /// Rays ended for crossing too many surfaces of equal index.
    pub straight_overflows: u64,
    /// Pixels that took more samples than the first, for what differs from a neighbour.
    pub edge_pixels: u64,
    /// Reflected and refracted rays left out for being too faint to matter.
    pub dropped_rays: u64,
    /// Shadow rays left out to lights that the surface faces away from.
    pub away_shadows: u64,
    /// Shadow rays left out where nothing could come back.
    pub black_shadows: u64,
    /// Shadow rays left out for light too faint to matter.
    pub faint_shadows: u64,
    /// Reflected and refracted rays left out for their weight of 0.
    pub weightless_rays: u64,
    /// Samples that the picture has from frames before, where this one traced none.
    pub kept_samples: u64,
    /// Bytes that a device has already, and was not brought for this frame.
    pub bytes_kept: u64,
    /// Trees neither built nor refitted for this frame, the one over instances among them.
    pub trees_kept: u64,
    /// Features that the scene does without and a device's kernels do not have.
    pub missing_features: u64,
    /// Bytes written to the tracer's buffers for this frame.
    pub bytes_uploaded: u64,
    /// Trees built or refitted for this frame.
    pub trees_updated: u64,
    /// Nodes of the tree over instances that were written to for this frame.
    pub tree_nodes: u64,
}

impl std::ops::Add for Counters {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            primary_rays: self.primary_rays + other.primary_rays,
            reflected_rays: self.reflected_rays + other.reflected_rays,
            refracted_rays: self.refracted_rays + other.refracted_rays,
            shadow_rays: self.shadow_rays + other.shadow_rays,
            media_overflows: self.media_overflows + other.media_overflows,
            straight_overflows: self.straight_overflows + other.straight_overflows,
            edge_pixels: self.edge_pixels + other.edge_pixels,
            dropped_rays: self.dropped_rays + other.dropped_rays,
            away_shadows: self.away_shadows + other.away_shadows,
            black_shadows: self.black_shadows + other.black_shadows,
            faint_shadows: self.faint_shadows + other.faint_shadows,
            weightless_rays: self.weightless_rays + other.weightless_rays,
            kept_samples: self.kept_samples + other.kept_samples,
            bytes_kept: self.bytes_kept + other.bytes_kept,
            trees_kept: self.trees_kept + other.trees_kept,
            missing_features: self.missing_features + other.missing_features,
            bytes_uploaded: self.bytes_uploaded + other.bytes_uploaded,
            trees_updated: self.trees_updated + other.trees_updated,
            tree_nodes: self.tree_nodes + other.tree_nodes,
        }
    }
}

impl Counters {
    /// These, with another's rays and what was left out of them: a device tells of those later than the host of the rest.
    pub fn with_rays_of(self, rays: Self) -> Self {
        Self {
            kept_samples: self.kept_samples,
            bytes_kept: self.bytes_kept,
            trees_kept: self.trees_kept,
            missing_features: self.missing_features,
            bytes_uploaded: self.bytes_uploaded,
            trees_updated: self.trees_updated,
            tree_nodes: self.tree_nodes,
            ..rays
        }
    }

    /// Every count with its name in words, in the order in which people are told.
    pub fn named(&self) -> [(&'static str, u64); 19] {
        [
            ("camera rays", self.primary_rays),
            ("mirrored rays", self.reflected_rays),
            ("refracted rays", self.refracted_rays),
            ("shadow rays", self.shadow_rays),
            ("pixels on edges", self.edge_pixels),
            ("bytes uploaded", self.bytes_uploaded),
            ("instance tree's nodes written", self.tree_nodes),
            ("trees updated", self.trees_updated),
            ("media that did not fit", self.media_overflows),
            ("straight rays ended", self.straight_overflows),
            (Skip::Kernels.saved(), self.missing_features),
            (Skip::Away.saved(), self.away_shadows),
            (Skip::Black.saved(), self.black_shadows),
            (Skip::FaintLights.saved(), self.faint_shadows),
            (Skip::FaintRays.saved(), self.dropped_rays),
            (Skip::Weightless.saved(), self.weightless_rays),
            (Skip::Still.saved(), self.kept_samples),
            (Skip::Trees.saved(), self.trees_kept),
            (Skip::Uploads.saved(), self.bytes_kept),
        ]
    }

    /// Rays of every kind.
    pub fn rays(&self) -> u64 {
        self.primary_rays + self.reflected_rays + self.refracted_rays + self.shadow_rays
    }

    /// What leaving something out has saved.
    pub fn saved(&self, skip: Skip) -> u64 {
        match skip {
            Skip::Kernels => self.missing_features,
            Skip::Away => self.away_shadows,
            Skip::Black => self.black_shadows,
            Skip::FaintLights => self.faint_shadows,
            Skip::FaintRays => self.dropped_rays,
            Skip::Weightless => self.weightless_rays,
            Skip::Still => self.kept_samples,
            Skip::Trees => self.trees_kept,
            Skip::Uploads => self.bytes_kept,
        }
    }
}
