//! Where notes are written: beside their places, and clear of each other.

use super::canvas::{Area, Chart, TICK_PX, fine, text_width_px};
use super::{Note, Panel, Side};

/// From the middle of a mark to its note.
const AWAY_PX: u32 = 9;
/// From one line of notes to the next.
const LINE_PX: u32 = 16;

/// Notes that would be in each other's way: written as lines of one block, level
/// with the middle of their places, and beside the farthest of them.
struct Block {
    /// From the highest to the lowest.
    notes: Vec<usize>,
    /// Where its lines begin, and the middle of each.
    across: i32,
    down: Vec<i32>,
}

impl Block {
    fn of(notes: Vec<usize>, all: &[Note], marks: &[(i32, i32)]) -> Self {
        let beside = notes.iter().map(|&k| match all[k].side {
            Side::Left => marks[k].0 - fine(AWAY_PX),
            Side::Right => marks[k].0 + fine(AWAY_PX),
        });
        let across = match all[notes[0]].side {
            Side::Left => beside.min(),
            Side::Right => beside.max(),
        };
        let count = notes.len() as i32;
        let middle = notes.iter().map(|&k| marks[k].1).sum::<i32>() / count;
        let first = middle - (count - 1) * fine(LINE_PX) / 2;
        let down = (0..count).map(|line| first + line * fine(LINE_PX)).collect();
        Self { notes, across: across.unwrap_or_default(), down }
    }

    /// Left and right ends, top and bottom.
    fn extent(&self, all: &[Note]) -> [(i32, i32); 2] {
        let widest = self.notes.iter().map(|&k| fine(text_width_px(&all[k].text, TICK_PX))).max();
        let width = widest.unwrap_or_default();
        let far = match all[self.notes[0]].side {
            Side::Left => self.across - width,
            Side::Right => self.across + width,
        };
        let ends = |line: Option<&i32>| line.copied().unwrap_or_default();
        let half = fine(LINE_PX) / 2;
        [
            (self.across.min(far), self.across.max(far)),
            (ends(self.down.first()) - half, ends(self.down.last()) + half),
        ]
    }

    fn meets(&self, other: &Self, all: &[Note]) -> bool {
        all[self.notes[0]].side == all[other.notes[0]].side
            && self
                .extent(all)
                .into_iter()
                .zip(other.extent(all))
                .all(|((low, high), (others_low, others_high))| low < others_high && others_low < high)
    }
}

/// Where each note's text begins, in the panel's pixels.
pub fn places(area: &Area, panel: &Panel, chart: &Chart) -> Vec<(i32, i32)> {
    let (origin_x, origin_y) = area.get_base_pixel();
    let mark = |note: &Note| {
        let (across, down) = chart.backend_coord(&note.at);
        (across - origin_x, down - origin_y)
    };
    let marks: Vec<(i32, i32)> = panel.notes.iter().map(mark).collect();
    let all = &panel.notes;
    let mut order: Vec<usize> = (0..marks.len()).collect();
    order.sort_by_key(|&k| marks[k].1);
    let mut blocks: Vec<Block> = Vec::new();
    for k in order {
        let mut block = Block::of(vec![k], all, &marks);
        // A block that grew may meet further ones.
        while let Some(met) = blocks.iter().position(|other| other.meets(&block, all)) {
            let mut notes = blocks.remove(met).notes;
            notes.append(&mut block.notes);
            notes.sort_by_key(|&k| marks[k].1);
            block = Block::of(notes, all, &marks);
        }
        blocks.push(block);
    }
    let mut places = marks;
    for block in blocks {
        for (k, down) in block.notes.into_iter().zip(block.down) {
            places[k] = (block.across, down);
        }
    }
    places
}
