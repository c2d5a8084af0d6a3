// What: what the kernels of a picture write, and the sum of what their invocations count.
// Reads: nothing. Writes: the report's counters.
// Twins: Canvas in engine/src/trace/cpu/canvas.rs; engine/src/trace/gpu/report.rs.
#define_import_path orrery::picture

#import orrery::types::CounterRow
#import orrery::counters as tally

// Counters, and behind them the pixels that take more samples than the first: report.counters.edge_pixels of them.
struct Report {
    counters: CounterRow,
    edges: array<u32>,
}

// Linear RGB, the mean of a pixel's samples; alpha is how many they are.
@group(2) @binding(0) var<storage, read_write> pixels: array<vec4f>;
@group(2) @binding(1) var<storage, read_write> report: Report;

#ifdef COUNTS
var<workgroup> group_primary: atomic<u32>;
var<workgroup> group_reflected: atomic<u32>;
var<workgroup> group_refracted: atomic<u32>;
var<workgroup> group_shadow: atomic<u32>;
var<workgroup> group_away: atomic<u32>;
var<workgroup> group_black: atomic<u32>;
var<workgroup> group_faint: atomic<u32>;
var<workgroup> group_weightless: atomic<u32>;
#endif

// Counts the rays of a sample, where anybody asks, and what did not fit, which is told always: that is rare, and goes straight
// to the sum. What is tallied and not read here costs nothing.
fn count_rays() {
#ifdef COUNTS
    atomicAdd(&group_primary, 1u);
    atomicAdd(&group_reflected, tally::reflected_rays);
    atomicAdd(&group_refracted, tally::refracted_rays);
    atomicAdd(&group_shadow, tally::shadow_rays);
    atomicAdd(&group_away, tally::away_shadows);
    atomicAdd(&group_black, tally::black_shadows);
    atomicAdd(&group_faint, tally::faint_shadows);
    atomicAdd(&group_weightless, tally::weightless_rays);
#ifdef SKIPS_FAINT_RAYS
    if tally::dropped_rays > 0u {
        atomicAdd(&report.counters.dropped_rays, tally::dropped_rays);
    }
#endif
#endif
#ifdef TRANSMISSION
    if tally::media_overflows > 0u {
        atomicAdd(&report.counters.media_overflows, tally::media_overflows);
    }
    if tally::straight_overflows > 0u {
        atomicAdd(&report.counters.straight_overflows, tally::straight_overflows);
    }
#endif
}

// Adds the workgroup's counts to the picture's; every invocation of the group calls this.
fn add_up(lane: u32) {
#ifdef COUNTS
    workgroupBarrier();
    if lane == 0u {
        atomicAdd(&report.counters.primary_rays, atomicLoad(&group_primary));
        atomicAdd(&report.counters.reflected_rays, atomicLoad(&group_reflected));
        atomicAdd(&report.counters.refracted_rays, atomicLoad(&group_refracted));
        atomicAdd(&report.counters.shadow_rays, atomicLoad(&group_shadow));
        atomicAdd(&report.counters.away_shadows, atomicLoad(&group_away));
        atomicAdd(&report.counters.black_shadows, atomicLoad(&group_black));
        atomicAdd(&report.counters.faint_shadows, atomicLoad(&group_faint));
        atomicAdd(&report.counters.weightless_rays, atomicLoad(&group_weightless));
    }
#endif
}
