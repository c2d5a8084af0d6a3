//! Colours of the profiler: every name has one, the same in every frame and every run.

use egui::Color32;

/// What systems may have: warm, so that passes of the device stand apart.
const HOST: [Color32; 8] = [
    Color32::from_rgb(205, 152, 74),
    Color32::from_rgb(186, 116, 82),
    Color32::from_rgb(196, 170, 104),
    Color32::from_rgb(168, 126, 104),
    Color32::from_rgb(214, 132, 96),
    Color32::from_rgb(158, 140, 86),
    Color32::from_rgb(190, 142, 122),
    Color32::from_rgb(222, 178, 118),
];
/// What passes may have: cold.
const DEVICE: [Color32; 5] = [
    Color32::from_rgb(92, 156, 196),
    Color32::from_rgb(102, 178, 174),
    Color32::from_rgb(124, 138, 204),
    Color32::from_rgb(84, 172, 148),
    Color32::from_rgb(142, 160, 190),
];
/// Waiting, which is no work.
pub const WAIT: Color32 = Color32::from_rgb(70, 76, 94);
/// On bright bars.
pub const INK: Color32 = Color32::from_rgb(20, 18, 14);

/// The colour of a span or pass.
pub fn of(name: &str, on_device: bool) -> Color32 {
    if is_wait(name) {
        return WAIT;
    }
    // FNV-1a: the same on every run.
    let hash = name.bytes().fold(0xcbf2_9ce4_8422_2325_u64, |hash, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
    });
    let place = (hash >> 20) as usize;
    if on_device {
        DEVICE[place % DEVICE.len()]
    } else {
        HOST[place % HOST.len()]
    }
}

/// Whether a step is a wait for the display.
fn is_wait(name: &str) -> bool {
    ["wait for an image", "hand the image over"].contains(&name)
}
