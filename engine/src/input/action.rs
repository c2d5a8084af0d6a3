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
    /// Show no level any more; then, select nothing.
    NoLevels,
    /// Select what is under the mouse in the picture.
    Select,
    /// Take the last edit back.
    Undo,
    /// Do the edit again that was taken back.
    Redo,
    /// Write the scene's file.
    Save,
    /// Write the scene to another file.
    SaveAs,
    /// Copy what is selected.
    Duplicate,
    /// Take away what is selected.
    Delete,
    /// Hide what is selected, or show it again.
    Hide,
    /// Move with the handles.
    Move,
    /// Turn with the handles.
    Rotate,
    /// Scale with the handles.
    Scale,
    /// Handles along the world's axes, or the thing's own.
    Axes,
    /// Bring what is selected into the middle of the view.
    Focus,
    /// Add something to the scene.
    Add,
}

impl Action {
    /// All, in the order in which help lists them.
    pub const ALL: [Self; 40] = [
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
        Self::Select,
        Self::Undo,
        Self::Redo,
        Self::Save,
        Self::SaveAs,
        Self::Duplicate,
        Self::Delete,
        Self::Hide,
        Self::Move,
        Self::Rotate,
        Self::Scale,
        Self::Axes,
        Self::Focus,
        Self::Add,
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
            Self::NoLevels => "No level, nothing selected",
            Self::Select => "Select; Ctrl, Shift: more; Alt: in mirrors",
            Self::Undo => "Undo",
            Self::Redo => "Redo",
            Self::Save => "Save",
            Self::SaveAs => "Save as",
            Self::Duplicate => "Duplicate",
            Self::Delete => "Delete",
            Self::Hide => "Hide or show",
            Self::Move => "Move; Ctrl snaps",
            Self::Rotate => "Rotate",
            Self::Scale => "Scale",
            Self::Axes => "World or own axes",
            Self::Focus => "Look at it",
            Self::Add => "Add",
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
            Self::Select
            | Self::Undo
            | Self::Redo
            | Self::Save
            | Self::SaveAs
            | Self::Duplicate
            | Self::Delete
            | Self::Hide
            | Self::Move
            | Self::Rotate
            | Self::Scale
            | Self::Axes
            | Self::Focus
            | Self::Add => "Edit",
            _ => "Camera",
        }
    }
}
