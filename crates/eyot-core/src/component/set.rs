//! The components of a world.

use super::kinds::other_kind;
use super::{Component, Shape, View};
use crate::error::Result;
use std::collections::BTreeMap;
use std::sync::Arc;

/// Components by name. A copy shares them until one of them is changed, so that saving a world before a step costs no memory for what
/// the step leaves alone.
#[derive(Clone, Debug, Default)]
pub struct Components(BTreeMap<String, Arc<dyn Component>>);

impl PartialEq for Components {
    fn eq(&self, other: &Self) -> bool {
        self.0.len() == other.0.len() && self.0.iter().zip(&other.0).all(|((a, x), (b, y))| a == b && x.equals(&**y))
    }
}

impl Components {
    /// All of them, in the order of their names.
    pub fn iter(&self) -> impl Iterator<Item = (&str, &dyn Component)> {
        self.0.iter().map(|(name, c)| (name.as_str(), &**c))
    }

    /// True if there is none.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.0.len()
    }

    /// True if there is one of that name.
    pub fn contains(&self, name: &str) -> bool {
        self.0.contains_key(name)
    }

    /// The component of that name, whatever it is.
    pub fn of_any_kind(&self, name: &str) -> Option<&dyn Component> {
        self.0.get(name).map(|c| &**c)
    }

    /// The component of that name; `None` if there is none.
    ///
    /// # Errors
    /// If it is of another type: what a process keeps under its name must not be taken for nothing.
    pub fn get<T: Component>(&self, name: &str) -> Result<Option<&T>> {
        let Some(component) = self.0.get(name) else { return Ok(None) };
        match component.as_any().downcast_ref() {
            Some(found) => Ok(Some(found)),
            None => Err(other_kind(name, &**component)),
        }
    }

    /// As [`Components::get`], to change. What a copy of the world shares is copied first.
    ///
    /// # Errors
    /// As [`Components::get`].
    pub fn get_mut<T: Component>(&mut self, name: &str) -> Result<Option<&mut T>> {
        self.get::<T>(name)?;
        let Some(shared) = self.0.get_mut(name) else { return Ok(None) };
        if Arc::get_mut(shared).is_none() {
            *shared = shared.copy();
        }
        Ok(Arc::get_mut(shared).and_then(|own| own.as_any_mut().downcast_mut()))
    }

    /// The component of that name, to change; made if it does not exist yet.
    ///
    /// # Errors
    /// As [`Components::get`].
    pub fn entry<T: Component + Clone + PartialEq>(&mut self, name: &str, make: impl FnOnce() -> T) -> Result<&mut T> {
        if !self.contains(name) {
            self.insert(name, make());
        }
        let component = self.get_mut(name)?;
        Ok(component.expect("it is there, and `get_mut` has checked its type"))
    }

    /// Puts a component in the place of whatever had that name.
    pub fn insert<T: Component + Clone + PartialEq>(&mut self, name: impl Into<String>, component: T) {
        self.insert_shared(name, Arc::new(component));
    }

    /// As [`Components::insert`], of a type that is not known here.
    pub fn insert_shared(&mut self, name: impl Into<String>, component: Arc<dyn Component>) {
        self.0.insert(name.into(), component);
    }

    /// Removes the component of that name; true if there was one.
    pub fn remove(&mut self, name: &str) -> bool {
        self.0.remove(name).is_some()
    }

    /// Bytes of memory that all of them hold.
    pub fn bytes(&self) -> usize {
        self.0.values().map(|c| c.bytes()).sum()
    }

    /// What can be shown of all of them: `NAME` is a component as a whole, `NAME.PART` a part of it.
    pub fn views(&self) -> impl Iterator<Item = (String, Shape)> + '_ {
        let full = |name: &str, part: &str| if part.is_empty() { name.to_owned() } else { format!("{name}.{part}") };
        self.iter().flat_map(move |(name, c)| c.views().iter().map(move |(part, shape)| (full(name, part), *shape)))
    }

    /// One of [`Components::views`].
    pub fn view(&self, name: &str) -> Option<View<'_>> {
        self.iter().find_map(|(component, c)| match name.strip_prefix(component)? {
            "" => c.view(""),
            part => c.view(part.strip_prefix('.')?),
        })
    }
}
