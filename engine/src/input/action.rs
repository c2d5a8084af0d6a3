//! What a person can do with keyboard and mouse, and what the help overlay calls it.

/// Something a person can do with a key.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Action {
    /// Move the camera along its view.
    Forward,
    /// Move the camera against its view.
    Back,
    /// Move the camera to its left.
    Left,
    /// Move the camera to its right.
    Right,
    /// Move the camera up in the world.
    Up,
    /// Move the camera down in the world.
    Down,
    /// Turn the camera to the left.
    TurnLeft,
    /// Turn the camera to the right.
    TurnRight,
    /// Turn the camera with the mouse.
    Look,
    /// Fly at four times the speed.
    Fast,
    /// Fly at a quarter of the speed.
    Slow,
    /// Change the speed of flight.
    Speed,
    /// Give the camera and the light back to the scene.
    Return,
    /// Move the light away from the camera.
    LightAway,
    /// Move the light towards the camera.
    LightNear,
    /// Move the light to the left.
    LightLeft,
    /// Move the light to the right.
    LightRight,
    /// Stop the clock, or let it go on.
    Pause,
    /// One frame further, and stop.
    Step,
    /// Show or hide the help.
    Help,
    /// Show or hide the panels.
    Panels,
    /// Show or hide the profiler.
    Profiler,
    /// Fill the screen, or not.
    Fullscreen,
    /// Save what is seen.
    Screenshot,
    /// Show a level of the trees over the picture, or hide the one that is shown.
    Levels,
    /// Show no level any more.
    NoLevels,
}

impl Action {
    /// All, in the order in which help lists them.
    pub const ALL: [Self; 26] = [
        Self::Look,
        Self::Forward,
        Self::Back,
        Self::Left,
        Self::Right,
        Self::Up,
        Self::Down,
        Self::TurnLeft,
        Self::TurnRight,
        Self::Fast,
        Self::Slow,
        Self::Speed,
        Self::Return,
        Self::LightAway,
        Self::LightNear,
        Self::LightLeft,
        Self::LightRight,
        Self::Pause,
        Self::Step,
        Self::Help,
        Self::Panels,
        Self::Profiler,
        Self::Fullscreen,
        Self::Screenshot,
        Self::Levels,
        Self::NoLevels,
    ];

    /// What help says.
    pub fn label(self) -> &'static str {
        match self {
            Self::Forward => "Fly forward",
            Self::Back => "Fly back",
            Self::Left => "Fly left",
            Self::Right => "Fly right",
            Self::Up => "Rise",
            Self::Down => "Sink",
            Self::TurnLeft => "Turn left",
            Self::TurnRight => "Turn right",
            Self::Look => "Look around",
            Self::Fast => "Faster, while held",
            Self::Slow => "Slower, while held",
            Self::Speed => "Change the speed",
            Self::Return => "Back to the scene's own path",
            Self::LightAway => "Light away from you",
            Self::LightNear => "Light towards you",
            Self::LightLeft => "Light to the left",
            Self::LightRight => "Light to the right",
            Self::Pause => "Pause",
            Self::Step => "One frame further",
            Self::Help => "This help",
            Self::Panels => "Panels",
            Self::Profiler => "Profiler",
            Self::Fullscreen => "Full screen",
            Self::Screenshot => "Screenshot",
            Self::Levels => "Level of the trees; 0: the leaves",
            Self::NoLevels => "No level",
        }
    }

    /// The heading help puts it under.
    pub fn group(self) -> &'static str {
        match self {
            Self::LightAway | Self::LightNear | Self::LightLeft | Self::LightRight => "Light",
            Self::Pause | Self::Step => "Time",
            Self::Levels | Self::NoLevels => "Hierarchies",
            Self::Help | Self::Panels | Self::Profiler | Self::Fullscreen | Self::Screenshot => {
                "Window"
            }
            _ => "Camera",
        }
    }
}
