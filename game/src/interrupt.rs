//! Ctrl-C: the first asks the command to stop after the picture in hand, the second stops it at once.

use std::sync::atomic::{AtomicBool, Ordering};

static ASKED: AtomicBool = AtomicBool::new(false);

/// Listens from now on. Where listening is refused, Ctrl-C keeps ending the program at once; pictures are
/// written beside their name and renamed, so even then none is left half done.
pub fn listen() {
    let listening = ctrlc::set_handler(|| {
        if ASKED.swap(true, Ordering::Relaxed) {
            std::process::exit(130);
        }
        crate::output::note("\nstopping after this picture; Ctrl-C again stops at once");
    });
    if let Err(error) = listening {
        tracing::debug!("Ctrl-C is not listened for: {error}");
    }
}

/// Whether Ctrl-C was pressed since [`listen`].
pub fn asked() -> bool {
    ASKED.load(Ordering::Relaxed)
}
