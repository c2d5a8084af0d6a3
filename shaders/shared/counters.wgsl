// What: what one invocation counts; the kernel adds it up at the end.
// Reads: nothing. Writes: its own tallies.
// Twin: Counters in engine/src/trace/counters.rs.
#define_import_path orrery::counters

var<private> reflected_rays: u32;
var<private> refracted_rays: u32;
var<private> shadow_rays: u32;
var<private> media_overflows: u32;
var<private> straight_overflows: u32;
var<private> dropped_rays: u32;
var<private> away_shadows: u32;
var<private> black_shadows: u32;
var<private> faint_shadows: u32;
var<private> weightless_rays: u32;
