//! What many hold and few change: copies share one allocation until one of them is written to.

use std::ops::{Deref, DerefMut};
use std::sync::Arc;

/// A value that is cloned in no time. Writing to it copies what others hold, too.
#[derive(Debug, Default, PartialEq)]
pub struct Shared<T>(Arc<T>);

impl<T> Clone for Shared<T> {
    fn clone(&self) -> Self {
        Shared(Arc::clone(&self.0))
    }
}

impl<T> From<T> for Shared<T> {
    fn from(value: T) -> Self {
        Shared(Arc::new(value))
    }
}

impl<T> Deref for Shared<T> {
    type Target = T;
    fn deref(&self) -> &T {
        &self.0
    }
}

impl<T: Clone> DerefMut for Shared<T> {
    fn deref_mut(&mut self) -> &mut T {
        Arc::make_mut(&mut self.0)
    }
}

impl<T: serde::Serialize> serde::Serialize for Shared<T> {
    fn serialize<S: serde::Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        self.0.serialize(to)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn copies_share_until_one_is_written_to() {
        let first = Shared::from(vec![1, 2, 3]);
        let mut second = first.clone();
        assert_eq!(first.as_ptr(), second.as_ptr());
        second[0] = 7;
        assert_eq!((&first[..], &second[..]), (&[1, 2, 3][..], &[7, 2, 3][..]));
    }
}
