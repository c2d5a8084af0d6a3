// What: sine, cosine and angles that are as good on every device: WGSL promises 2^-11, this gives a few ulp.
// Reads: nothing. Writes: nothing.
// Twin: engine/src/geom/trig.rs.
#define_import_path orrery::trig

// 2 / pi, and pi / 2 in three parts of few bits: up to 2^13 times the first two is exact, fused or not
// (Cody and Waite 1980).
const QUARTERS: f32 = 0.63661975;
const HIGH: f32 = 1.5703125;
const MIDDLE: f32 = 4.837513e-4;
const LOW: f32 = 7.54979e-8;

// (sin, cos) of an angle. Brought to [-pi/4, pi/4]; polynomials of the Cephes library (Moshier; sinf.c).
fn sin_cos(angle: f32) -> vec2f {
    let quarter_turns = round(angle * QUARTERS);
    let reduced = angle - quarter_turns * HIGH - quarter_turns * MIDDLE - quarter_turns * LOW;
    // Far out the reduction is worthless; this keeps the polynomials from running away.
    let x = clamp(reduced, -0.8, 0.8);
    let z = x * x;
    let s = ((-1.9515296e-4 * z + 8.332161e-3) * z - 1.6666655e-1) * z * x + x;
    let c = ((2.4433157e-5 * z - 1.3887316e-3) * z + 4.1666646e-2) * z * z - 0.5 * z + 1.0;
    let quadrant = i32(quarter_turns);
    let turned = select(vec2f(s, c), vec2f(c, s), (quadrant & 1) != 0);
    return select(turned, -turned, vec2<bool>((quadrant & 2) != 0, ((quadrant + 1) & 2) != 0));
}

// Angle of the point (x, y) from the x axis, -pi to pi; 1e-5 off at most. Polynomial: Abramowitz and Stegun 4.4.49's form,
// minimax on [0, 1].
fn angle_of(y: f32, x: f32) -> f32 {
    let low = min(abs(x), abs(y));
    let high = max(max(abs(x), abs(y)), 1e-30);
    let t = low / high;
    let z = t * t;
    var angle = ((((-0.0117212 * z + 0.05265332) * z - 0.11643287) * z + 0.19354346) * z - 0.33262347) * z * t + 0.99997726 * t;
    angle = select(angle, 1.5707964 - angle, abs(y) > abs(x));
    angle = select(angle, 3.1415927 - angle, x < 0.0);
    return select(angle, -angle, y < 0.0);
}
