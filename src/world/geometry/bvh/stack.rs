//! What a walk has put off.

use super::collapse::DEEPEST;
use std::mem::MaybeUninit;

/// Seven from each level of the deepest tree, and a few.
const ROOM: usize = (7 * DEEPEST + 1).next_power_of_two();

/// What is left to look at: places below `top` are written, the others are not, so that starting costs nothing.
pub struct Stack {
    items: [MaybeUninit<u64>; ROOM],
    top: usize,
}

impl Stack {
    #[inline(always)]
    pub fn new() -> Stack {
        Stack { items: [const { MaybeUninit::uninit() }; ROOM], top: 0 }
    }

    /// Puts a key among those at `base` and above, which descend. False if there is no room.
    #[inline(always)]
    pub fn insert(&mut self, key: u64, base: usize) -> bool {
        if self.top >= ROOM {
            return false;
        }
        let mut at = self.top;
        while at > base {
            // SAFETY: a place below the top, see above.
            let below = unsafe { self.items[(at - 1) % ROOM].assume_init() };
            if below >= key {
                break;
            }
            self.items[at % ROOM].write(below);
            at -= 1;
        }
        self.items[at % ROOM].write(key);
        self.top += 1;
        true
    }

    /// How many there are.
    #[inline(always)]
    pub fn top(&self) -> usize {
        self.top
    }

    #[inline(always)]
    pub fn pop(&mut self) -> Option<u64> {
        self.top = self.top.checked_sub(1)?;
        // SAFETY: it was below the top, see above.
        Some(unsafe { self.items[self.top % ROOM].assume_init() })
    }
}
