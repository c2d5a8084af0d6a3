//! Can a window open here? winit loads its system libraries at run time and panics over some that are
//! missing, so they are looked for first.

/// Whether a window can open.
///
/// # Errors
/// What is missing, and what to do about it.
#[cfg(target_os = "linux")]
pub fn display_available() -> Result<(), String> {
    let set = |name: &str| std::env::var_os(name).is_some_and(|value| !value.is_empty());
    let wayland = set("WAYLAND_DISPLAY") || set("WAYLAND_SOCKET");
    let x11 = set("DISPLAY");
    if !wayland && !x11 {
        return Err("neither WAYLAND_DISPLAY nor DISPLAY is set".into());
    }
    let missing = if wayland {
        missing_on_wayland()
    } else {
        missing_on_x11()
    };
    if missing.is_empty() {
        Ok(())
    } else {
        Err(format!(
            "the window needs {}; on Debian: apt install libxkbcommon-x11-0 libxcursor1 libxi6 libxrandr2",
            missing.join(" and ")
        ))
    }
}

/// Whether a window can open.
///
/// # Errors
/// Never here: this system's window library is part of it.
#[cfg(not(target_os = "linux"))]
pub fn display_available() -> Result<(), String> {
    Ok(())
}

/// Libraries that reading keys needs.
#[cfg(target_os = "linux")]
fn missing_for_keys() -> Vec<&'static str> {
    let mut missing = Vec::new();
    if xkbcommon_dl::xkbcommon_option().is_none() {
        missing.push("libxkbcommon.so.0");
    } else if xkbcommon_dl::xkbcommon_compose_option().is_none() {
        missing.push("libxkbcommon.so.0 with its compose part");
    }
    missing
}

#[cfg(target_os = "linux")]
fn missing_on_wayland() -> Vec<&'static str> {
    missing_for_keys()
}

#[cfg(target_os = "linux")]
fn missing_on_x11() -> Vec<&'static str> {
    let mut missing = missing_for_keys();
    let libraries = [
        (
            "libxkbcommon-x11.so.0",
            xkbcommon_dl::x11::xkbcommon_x11_option().is_some(),
        ),
        ("libX11.so.6", x11_dl::xlib::Xlib::open().is_ok()),
        (
            "libX11-xcb.so.1",
            x11_dl::xlib_xcb::Xlib_xcb::open().is_ok(),
        ),
        ("libXcursor.so.1", x11_dl::xcursor::Xcursor::open().is_ok()),
        ("libXi.so.6", x11_dl::xinput2::XInput2::open().is_ok()),
    ];
    missing.extend(
        libraries
            .iter()
            .filter(|(_, found)| !found)
            .map(|(name, _)| name),
    );
    missing
}
