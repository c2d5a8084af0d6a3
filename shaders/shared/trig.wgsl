// What: sine and cosine that are as good on every device: WGSL promises 2^-11, this gives a few ulp.
// Reads: nothing. Writes: nothing.
// Twin: engine/src/geom/trig.rs.
#define_import_path orrery::trig

// 2 / pi, and pi / 2 in three parts of few bits: a multiple below 2^13 of the first two is exact (Cody and Waite 1980).
const QUARTERS: f32 = 0.636619772;
const QUARTER_HIGH: f32 = 1.5703125;
const QUARTER_MIDDLE: f32 = 4.837512969970703125e-4;
const QUARTER_LOW: f32 = 7.54978995489188216e-8;

// (sin x, cos x). The angle is brought to [-pi/4, pi/4]; polynomials of the Cephes library (Moshier), sinf and cosf.
fn sin_cos(x: f32) -> vec2f {
    let quarters = round(x * QUARTERS);
    let r = ((x - quarters * QUARTER_HIGH) - quarters * QUARTER_MIDDLE) - quarters * QUARTER_LOW;
    let z = r * r;
    let s = r + r * z * (-1.6666654611e-1 + z * (8.3321608736e-3 + z * -1.9515295891e-4));
    let c = 1.0 - 0.5 * z + z * z * (4.166664568298827e-2 + z * (-1.388731625493765e-3 + z * 2.443315711809948e-5));
    let turn = u32(i32(quarters)) & 3u;
    let swapped = select(vec2f(s, c), vec2f(c, s), (turn & 1u) == 1u);
    let sign_of_sin = select(1.0, -1.0, turn >= 2u);
    let sign_of_cos = select(1.0, -1.0, turn == 1u || turn == 2u);
    return swapped * vec2f(sign_of_sin, sign_of_cos);
}
