//! One widget a field, chosen by its reflected type; what is changed comes back as a path and a value.

mod pickers;
mod units;

use bevy_ecs::prelude::*;
use bevy_reflect::enums::{DynamicEnum, DynamicVariant, Enum, VariantInfo};
use bevy_reflect::std_traits::ReflectDefault;
use bevy_reflect::structs::DynamicStruct;
use bevy_reflect::tuple::DynamicTuple;
use bevy_reflect::{PartialReflect, ReflectRef, TypeInfo, TypeRegistry};
use glam::{DQuat, DVec2, DVec3, EulerRot, Vec2, Vec3};

use self::pickers::Picked;
use self::units::Unit;
use super::naming::spaced;
use super::theme;
use crate::world::TextureId;

/// Width of the column of names.
const NAME_WIDTH: f32 = 96.0;
/// Rows of a list that are shown; a polygon of a thousand corners is not edited by hand.
const LONGEST_LIST: usize = 32;

/// A field that was changed.
pub struct FieldEdit {
    /// Path within the component.
    pub path: String,
    /// New value of the field there.
    pub value: Box<dyn PartialReflect>,
}

/// Draws a value and collects what is changed in it.
pub struct Fields<'a> {
    registry: &'a TypeRegistry,
    world: &'a World,
    /// The component's type, as Rust has it.
    component: String,
    path: String,
    /// Changes, in order.
    pub edits: Vec<FieldEdit>,
    /// An entity whose link was clicked.
    pub jump: Option<Entity>,
}

impl<'a> Fields<'a> {
    /// Nothing drawn yet.
    pub fn new(registry: &'a TypeRegistry, world: &'a World) -> Self {
        Self {
            registry,
            world,
            component: String::new(),
            path: String::new(),
            edits: Vec::new(),
            jump: None,
        }
    }

    /// Draws a whole component.
    pub fn show(&mut self, ui: &mut egui::Ui, name: &str, value: &dyn PartialReflect) {
        self.component = name.to_owned();
        if !self.leaf(ui, name, value) {
            self.parts(ui, value);
        }
    }

    fn edit(&mut self, value: impl PartialReflect) {
        self.edits.push(FieldEdit {
            path: self.path.clone(),
            value: Box::new(value),
        });
    }

    /// Draws a field under its name: on one line if it is simple, else indented below.
    fn field(&mut self, ui: &mut egui::Ui, step: &str, name: &str, value: &dyn PartialReflect) {
        let length = self.path.len();
        self.path.push_str(step);
        if !self.leaf(ui, name, value) {
            ui.label(theme::faint(spaced(name)));
            let salt = self.path.clone();
            ui.push_id(salt, |ui| {
                ui.indent("parts", |ui| self.parts(ui, value));
            });
        }
        self.path.truncate(length);
    }

    /// The parts of a value that has some.
    fn parts(&mut self, ui: &mut egui::Ui, value: &dyn PartialReflect) {
        match value.reflect_ref() {
            ReflectRef::Struct(parts) => {
                for (i, (_, part)) in parts.iter_fields().enumerate() {
                    let name = parts.name_at(i).unwrap_or("?");
                    self.field(ui, &format!(".{name}"), name, part);
                }
            }
            ReflectRef::TupleStruct(parts) => {
                for (i, part) in parts.iter_fields().enumerate() {
                    self.field(ui, &format!(".{i}"), "value", part);
                }
            }
            ReflectRef::Tuple(parts) => {
                for (i, part) in parts.iter_fields().enumerate() {
                    self.field(ui, &format!(".{i}"), &i.to_string(), part);
                }
            }
            ReflectRef::List(parts) => self.items(ui, parts.len(), parts.iter()),
            ReflectRef::Array(parts) => self.items(ui, parts.len(), parts.iter()),
            ReflectRef::Enum(value) => self.choice(ui, "", value),
            _ => {
                ui.label(theme::faint(format!("{value:?}")));
            }
        }
    }

    fn items<'v>(
        &mut self,
        ui: &mut egui::Ui,
        count: usize,
        items: impl Iterator<Item = &'v dyn PartialReflect>,
    ) {
        for (i, item) in items.take(LONGEST_LIST).enumerate() {
            self.field(ui, &format!("[{i}]"), &format!("{i}"), item);
        }
        if count > LONGEST_LIST {
            ui.label(theme::faint(format!("and {} more", count - LONGEST_LIST)));
        }
    }

    /// Draws a value that fits on one line; false if it does not.
    fn leaf(&mut self, ui: &mut egui::Ui, name: &str, value: &dyn PartialReflect) -> bool {
        if self.number(ui, name, value) {
            return true;
        }
        if let Some(&before) = value.try_downcast_ref::<bool>() {
            let mut now = before;
            line(ui, name, |ui| ui.checkbox(&mut now, ""));
            if now != before {
                self.edit(now);
            }
        } else if let Some(before) = value.try_downcast_ref::<String>() {
            let mut now = before.clone();
            line(ui, name, |ui| ui.text_edit_singleline(&mut now));
            if now != *before {
                self.edit(now);
            }
        } else if let Some(text) = value.try_downcast_ref::<Name>() {
            line(ui, "name", |ui| ui.label(text.as_str()));
        } else {
            return self.reference(ui, name, value) || self.vector(ui, name, value);
        }
        true
    }

    /// A number, in its unit.
    fn number(&mut self, ui: &mut egui::Ui, name: &str, value: &dyn PartialReflect) -> bool {
        macro_rules! whole_numbers {
            ($($number:ty),*) => {
                $(if let Some(&before) = value.try_downcast_ref::<$number>() {
                    let mut now = before;
                    line(ui, name, |ui| ui.add(egui::DragValue::new(&mut now).speed(0.1)));
                    if now != before {
                        self.edit(now);
                    }
                    return true;
                })*
            };
        }
        whole_numbers!(u8, u16, u32, u64, usize, i8, i16, i32, i64, isize);
        let unit = Unit::of(&self.component, name);
        if let Some(&before) = value.try_downcast_ref::<f64>() {
            if let Some(now) = in_unit(ui, name, &unit, before) {
                self.edit(now);
            }
        } else if let Some(&before) = value.try_downcast_ref::<f32>() {
            if let Some(now) = in_unit(ui, name, &unit, f64::from(before)) {
                self.edit(now as f32);
            }
        } else {
            return false;
        }
        true
    }

    /// What the field refers to, chosen from a list; false if it refers to nothing of that kind.
    fn reference(&mut self, ui: &mut egui::Ui, name: &str, value: &dyn PartialReflect) -> bool {
        let salt = format!("{} {}", self.component, self.path);
        if let Some(&now) = value.try_downcast_ref::<Entity>() {
            let materials = self.component == "Surface";
            let name = if materials { "material" } else { name };
            let picked = line(ui, name, |ui| {
                pickers::entity(ui, self.world, &salt, (now, materials))
            });
            match picked {
                Some(Picked::Entity(entity)) => self.edit(entity),
                Some(Picked::Jump(entity)) => self.jump = Some(entity),
                None => {}
            }
        } else if let Some(&now) = value.try_downcast_ref::<Option<TextureId>>() {
            let picked = line(ui, name, |ui| pickers::texture(ui, self.world, &salt, now));
            if let Some(next) = picked.flatten() {
                self.edit(Some(next));
            } else if picked == Some(None) {
                self.edit(None::<TextureId>);
            }
        } else {
            return false;
        }
        true
    }

    /// Vectors, rotations and colours.
    fn vector(&mut self, ui: &mut egui::Ui, name: &str, value: &dyn PartialReflect) -> bool {
        if let Some(&before) = value.try_downcast_ref::<Vec3>() {
            let mut now = before.as_dvec3().to_array();
            let is_color = name == "color" || self.path.ends_with(".reflection.0");
            line(ui, name, |ui| {
                if is_color {
                    swatch(ui, &mut now);
                }
                axes(ui, &mut now, pace(before.length().into()));
            });
            let now = DVec3::from_array(now).as_vec3();
            if now != before {
                self.edit(now);
            }
        } else if let Some(&before) = value.try_downcast_ref::<DVec3>() {
            let mut now = before.to_array();
            line(ui, name, |ui| axes(ui, &mut now, pace(before.length())));
            if now != before.to_array() {
                self.edit(DVec3::from_array(now));
            }
        } else if let Some(&before) = value.try_downcast_ref::<Vec2>() {
            let mut now = before.as_dvec2().to_array();
            line(ui, name, |ui| {
                axes(ui, &mut now, pace(before.length().into()))
            });
            let now = DVec2::from_array(now).as_vec2();
            if now != before {
                self.edit(now);
            }
        } else if let Some(&before) = value.try_downcast_ref::<DQuat>() {
            let (y, x, z) = before.to_euler(EulerRot::YXZ);
            // Adding zero turns -0 into 0.
            let degrees = [x, y, z].map(|radians| (radians.to_degrees() * 1e3).round() / 1e3 + 0.0);
            let mut now = degrees;
            line(ui, name, |ui| axes(ui, &mut now, 0.5));
            if now != degrees {
                let [x, y, z] = now.map(f64::to_radians);
                self.edit(DQuat::from_euler(EulerRot::YXZ, y, x, z).normalize());
            }
        } else if let ReflectRef::Enum(value) = value.reflect_ref() {
            self.choice(ui, name, value);
        } else {
            return false;
        }
        true
    }

    /// A choice of variants, and below it the fields of the chosen one.
    fn choice(&mut self, ui: &mut egui::Ui, name: &str, value: &dyn Enum) {
        let Some(TypeInfo::Enum(info)) = value.get_represented_type_info() else {
            line(ui, name, |ui| ui.label(theme::faint(value.variant_name())));
            return;
        };
        let mut chosen = value.variant_index();
        line(ui, name, |ui| {
            egui::ComboBox::from_id_salt((&self.path, name))
                .selected_text(spaced(value.variant_name()))
                .show_ui(ui, |ui| {
                    for (i, variant) in info.iter().enumerate() {
                        ui.selectable_value(&mut chosen, i, spaced(variant.name()));
                    }
                });
        });
        if chosen != value.variant_index() {
            let variant = info
                .variant_at(chosen)
                .and_then(|variant| self.fresh(variant));
            if let Some(variant) = variant {
                self.edit(variant);
            }
            return;
        }
        let salt = ("variant", self.path.clone());
        ui.indent(salt, |ui| {
            for (i, field) in value.iter_fields().enumerate() {
                match value.name_at(i) {
                    Some(name) => self.field(ui, &format!(".{name}"), name, field.value()),
                    // An option's content goes without a name, into the same column.
                    None => self.content(ui, i, field.value()),
                }
            }
        });
    }

    fn content(&mut self, ui: &mut egui::Ui, index: usize, value: &dyn PartialReflect) {
        let length = self.path.len();
        self.path.push_str(&format!(".{index}"));
        if !self.leaf(ui, "value", value) {
            self.parts(ui, value);
        }
        self.path.truncate(length);
    }

    /// A variant with the default of each of its fields; none if one of them has no default.
    fn fresh(&self, variant: &VariantInfo) -> Option<DynamicEnum> {
        let content = match variant {
            VariantInfo::Unit(_) => DynamicVariant::Unit,
            VariantInfo::Tuple(tuple) => {
                let mut content = DynamicTuple::default();
                for field in tuple.iter() {
                    content.insert_boxed(self.default_of(field.type_id())?);
                }
                DynamicVariant::Tuple(content)
            }
            VariantInfo::Struct(parts) => {
                let mut content = DynamicStruct::default();
                for field in parts.iter() {
                    content.insert_boxed(field.name(), self.default_of(field.type_id())?);
                }
                DynamicVariant::Struct(content)
            }
        };
        Some(DynamicEnum::new(variant.name(), content))
    }

    fn default_of(&self, id: std::any::TypeId) -> Option<Box<dyn PartialReflect>> {
        // Zero is a bad start for angles, heights and distances.
        if id == std::any::TypeId::of::<f64>() {
            return Some(Box::new(1.0_f64));
        }
        if id == std::any::TypeId::of::<Vec3>() {
            return Some(Box::new(Vec3::splat(0.8)));
        }
        let default = self.registry.get_type_data::<ReflectDefault>(id)?;
        Some(default.default().into_partial_reflect())
    }
}

/// A name on the left, a widget on the right, aligned over all lines.
fn line<R>(ui: &mut egui::Ui, name: &str, widget: impl FnOnce(&mut egui::Ui) -> R) -> R {
    ui.horizontal(|ui| {
        let height = ui.spacing().interact_size.y;
        ui.allocate_ui_with_layout(
            egui::vec2(NAME_WIDTH, height),
            egui::Layout::left_to_right(egui::Align::Center),
            |ui| {
                ui.set_min_width(NAME_WIDTH);
                ui.add(egui::Label::new(theme::faint(spaced(name))).truncate());
            },
        );
        widget(ui)
    })
    .inner
}

/// A number as its unit has it; the held number if it was changed.
fn in_unit(ui: &mut egui::Ui, name: &str, unit: &Unit, before: f64) -> Option<f64> {
    let shown = unit.shown(before);
    let mut now = shown;
    line(ui, name, |ui| {
        if unit.slides {
            ui.spacing_mut().slider_width = (ui.available_width() - 62.0).max(30.0);
            ui.add(egui::Slider::new(&mut now, unit.range.clone()).max_decimals(3));
        } else {
            let pace = unit.pace.unwrap_or_else(|| pace(shown));
            let field = egui::DragValue::new(&mut now).speed(pace).max_decimals(4);
            // What is out of range already is shown as it is until somebody changes it.
            let field = field
                .range(unit.range.clone())
                .clamp_existing_to_range(false);
            ui.add(field.suffix(unit.suffix));
        }
    });
    (now != shown).then(|| unit.held(now))
}

/// Numbers side by side.
fn axes(ui: &mut egui::Ui, values: &mut [f64], pace: f64) {
    ui.spacing_mut().item_spacing.x = 4.0;
    for value in values {
        ui.add(egui::DragValue::new(value).speed(pace).max_decimals(3));
    }
}

/// A colour to click; linear, clamped for showing only.
fn swatch(ui: &mut egui::Ui, color: &mut [f64; 3]) {
    let shown = color.map(|channel| channel.clamp(0.0, 1.0) as f32);
    let mut picked = shown;
    // The picker edits sRGB-encoded light as linear numbers, which is what the world holds.
    egui::color_picker::color_edit_button_rgb(ui, &mut picked);
    if picked != shown {
        *color = picked.map(f64::from);
    }
}

/// How much a number changes for a pixel of dragging: in proportion, but never stuck at zero.
fn pace(value: f64) -> f64 {
    (value.abs() * 0.005).max(0.005)
}
