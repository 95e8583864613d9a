//! Which trains show one image: what comes over gratings comes the same way, however often it is reflected between them.

use eyebox_base::chain::{Link, Step};

/// What two trains that show one image have alike: the orders by which parts bend their light, and the faces before the first of these
/// and after the last. None of a train without diffracted orders: each shows an image of its own.
pub(super) fn image(links: &[Link]) -> Option<Vec<(u32, Step, i32)>> {
    let is_bent = |link: &Link| link.order != 0;
    let (first, last) = (links.iter().position(is_bent)?, links.iter().rposition(is_bent)?);
    let own = |link: &Link| (link.part, link.step, link.order);
    let mut key: Vec<_> = links[..=first].iter().map(own).collect();
    if first < last {
        // A face that bends light there and back again has done nothing, as a fold that light crosses in steps.
        let mut between: Vec<&Link> = Vec::new();
        for link in links[first + 1..last].iter().filter(|link| is_bent(link)) {
            let undoes = |other: &&Link| {
                (other.part, other.face) == (link.part, link.face) && other.order.checked_add(link.order) == Some(0)
            };
            if between.last().is_some_and(undoes) {
                between.pop();
            } else {
                between.push(link);
            }
        }
        key.extend(between.into_iter().map(own));
        key.extend(links[last..].iter().map(own));
    }
    Some(key)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn link(face: u32, order: i32) -> Link {
        Link { part: 3, face, step: if order == 0 { Step::Through } else { Step::Back }, order }
    }

    #[test]
    fn reflections_between_gratings_and_turns_that_undo_each_other_are_one_image() {
        let way =
            |orders: &[(u32, i32)]| image(&orders.iter().map(|(face, order)| link(*face, *order)).collect::<Vec<_>>());
        let main = way(&[(0, -1), (9, 0), (1, 1), (9, 0), (2, 1)]);
        assert!(main.is_some());
        assert_eq!(main, way(&[(0, -1), (1, 1), (2, 1)]));
        assert_eq!(main, way(&[(0, -1), (1, 1), (9, 0), (1, -1), (1, 1), (2, 1)]));
        // Another order, one face less, another way before the first of them.
        assert_ne!(main, way(&[(0, -1), (1, 2), (2, 1)]));
        assert_ne!(main, way(&[(0, -1), (2, 1)]));
        assert_ne!(main, way(&[(9, 0), (0, -1), (1, 1), (2, 1)]));
        // What comes in and out at one face is bent all the same.
        assert_eq!(way(&[(0, -1), (0, 1)]).map(|key| key.len()), Some(2));
        assert_eq!(way(&[(9, 0)]), None);
    }
}
