//! Why a command ended without doing what it was asked, and the exit code that says so.

use std::fmt;

use orrery_engine::trace::TraceError;

/// A command's failure. The sentence says what was wrong, where, and what to do.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Failure {
    /// The input is bad: a file, its content, a place to write to.
    Input(String),
    /// The command line asks for something it cannot ask for.
    Usage(String),
    /// What was measured is not as it must be.
    Missed(String),
    /// No device that could trace.
    NoDevice(String),
    /// The user stopped it.
    Interrupted(String),
}

impl Failure {
    /// 1 input or a missed target, 2 usage, 3 no device, 130 interrupted (what shells give for Ctrl-C).
    pub fn exit_code(&self) -> u8 {
        match self {
            Self::Input(_) | Self::Missed(_) => 1,
            Self::Usage(_) => 2,
            Self::NoDevice(_) => 3,
            Self::Interrupted(_) => 130,
        }
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (Self::Input(why)
        | Self::Missed(why)
        | Self::Usage(why)
        | Self::NoDevice(why)
        | Self::Interrupted(why)) = self;
        f.write_str(why)
    }
}

impl From<TraceError> for Failure {
    fn from(error: TraceError) -> Self {
        match error {
            TraceError::TooLarge(why) => Self::Input(why),
            TraceError::NoDevice(why) | TraceError::Device(why) | TraceError::DeviceLost(why) => {
                Self::NoDevice(why)
            }
        }
    }
}
