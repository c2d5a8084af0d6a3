// What: leaving out rays too faint to matter, within a bound that holds for every pixel. Each camera ray has a
// purse, the error it may make, and pays from it for each ray that is not followed.
// Reads: the view. Writes: the invocation's purse.
// Twin: engine/src/trace/cpu/cutoff.rs, which has the argument.
#define_import_path orrery::cutoff

#import orrery::scene::view

// Least payment, as a share of what the purse holds: more than its last digits (2^-18).
const LEAST_PAYMENT: f32 = 3.814697265625e-6;

// What this camera ray may still leave out.
var<private> purse: f32;

// For the camera ray of a pixel's sample of this number. First samples of adaptive pictures leave out nothing: which
// pixels take more must not depend on what is left out.
fn fill_purse(index: u32) {
    let finds_edges = index == 0u && view.edge_contrast > 0.0;
    purse = select(view.cutoff, 0.0, finds_edges);
}

// Pays for leaving out a ray that costs so much, if it can. What costs nothing is not bought.
fn buys(cost: f32) -> bool {
    if cost <= 0.0 || cost > purse {
        return false;
    }
    purse -= max(cost, purse * LEAST_PAYMENT);
    return true;
}

// The most that a ray of this weight and generation adds to a channel of its sample.
fn most_added(weight: vec3f, generation: u32) -> f32 {
    if generation > view.max_generations {
        return 0.0;
    }
    let index = generation - 1u;
    let brightest = max(weight.x, max(weight.y, weight.z));
    return brightest * view.bounds[index >> 2u][index & 3u];
}
