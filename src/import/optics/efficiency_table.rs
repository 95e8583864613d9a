//! Efficiencies of a grating from a text file: a line of column names, then a line for every order at every pair of a wavelength
//! and a direction, in any order, separated by commas, semicolons, tabs or blanks. `#` starts a comment.

use super::grating::MOST_ORDERS;
use crate::text::{SEPARATORS, cells};
use eyebox_base::error::Result;
use eyebox_base::{Code, Error, Where};
use eyebox_scene::Grating;
use eyebox_scene::efficiency_table::{Efficiency, EfficiencyGrid, EfficiencyTable};
use std::fmt;
use std::path::Path;

/// A column, and what its numbers may be.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Column {
    Wavelength,
    Angle,
    Conical,
    Order,
    Side,
    /// Of s and p, of s, of p.
    Transmittance(Of),
    Reflectance(Of),
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Of {
    Both,
    S,
    P,
}

const COLUMNS: [(&str, Column); 11] = [
    ("wavelength_nm", Column::Wavelength),
    ("angle_deg", Column::Angle),
    ("conical_deg", Column::Conical),
    ("order", Column::Order),
    ("side", Column::Side),
    ("T", Column::Transmittance(Of::Both)),
    ("T_s", Column::Transmittance(Of::S)),
    ("T_p", Column::Transmittance(Of::P)),
    ("R", Column::Reflectance(Of::Both)),
    ("R_s", Column::Reflectance(Of::S)),
    ("R_p", Column::Reflectance(Of::P)),
];

/// No solver or goniometer writes more lines; a file that has them is no such table.
const MOST_LINES: usize = 1 << 20;

/// A line of the table.
#[derive(Debug, Clone, Copy)]
struct Row {
    line: usize,
    back: bool,
    order: i32,
    /// nm, deg, deg.
    at: [f64; 3],
    value: Efficiency,
}

impl fmt::Display for Row {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [nm, angle, conical] = self.at;
        write!(f, "order {}, {nm} nm, {angle}°", self.order)?;
        if conical != 0.0 { write!(f, ", conical {conical}°") } else { Ok(()) }
    }
}

/// The table in `file`, named at `named`.
///
/// # Errors
/// By its line: an unknown or missing column, what is no number or out of range, a second line of one point, orders that together have
/// more light than there is. An order that lacks a line.
pub fn efficiency_table(bytes: &[u8], file: &Path, named: &Where) -> Result<EfficiencyTable> {
    let text = std::str::from_utf8(bytes).map_err(|_| {
        Error::new(named.clone(), format!("the efficiencies {} are not a text", file.display()))
            .expected(format!("lines of values with {SEPARATORS}"))
    })?;
    let here = |line: usize| Where::Line { file: file.to_owned(), line };
    let mut lines = text.trim_start_matches('\u{feff}').lines().enumerate().map(|(index, line)| {
        let said = line.split('#').next().unwrap_or("").trim();
        (index + 1, said)
    });
    let mut lines = lines.by_ref().filter(|(_, said)| !said.is_empty());
    let Some((line, head)) = lines.next() else {
        return Err(Error::new(Where::file(file), "the table of efficiencies is empty").expected(names()));
    };
    let columns = columns(head, &|| here(line))?;
    let (mut rows, mut last): (Vec<Row>, usize) = (Vec::new(), line);
    for (line, said) in lines {
        if rows.len() == MOST_LINES {
            return Err(Error::new(here(line), "the table of efficiencies has too many lines")
                .expected(format!("{MOST_LINES} at most")));
        }
        rows.push(row(&columns, said, line, &|| here(line))?);
        last = line;
    }
    let mut orders: Vec<i32> = rows.iter().map(|row| row.order).collect();
    orders.sort_unstable();
    orders.dedup();
    if orders.is_empty() || orders.len() > MOST_ORDERS {
        let what = format!("the table of efficiencies has {} orders", orders.len());
        return Err(Error::new(here(last), what).expected(format!("1 to {MOST_ORDERS}: those that carry light")));
    }
    let of = |back: bool| -> Vec<Row> { rows.iter().filter(|row| row.back == back).copied().collect() };
    let by_side = columns.iter().any(|(_, column)| *column == Column::Side);
    let grid = |back: bool| grid(of(back), &orders, (by_side, back), file);
    let back = by_side.then(|| grid(true)).transpose()?;
    Ok(EfficiencyTable { file: file.display().to_string(), front: grid(false)?, orders, back })
}

fn names() -> String {
    let names: Vec<&str> = COLUMNS.iter().map(|(name, _)| *name).collect();
    format!("columns of {}, with {SEPARATORS}", names.join(", "))
}

/// Some of a line, for a message.
fn shown(said: &str) -> String {
    said.chars().take(60).collect()
}

/// The columns, as the first line names them.
fn columns(head: &str, at: &dyn Fn() -> Where) -> Result<Vec<(&'static str, Column)>> {
    let mut columns: Vec<(&'static str, Column)> = Vec::new();
    for cell in cells(head) {
        let known = COLUMNS.iter().find(|(name, _)| *name == cell).ok_or_else(|| {
            Error::new(at(), format!("`{}` is no column of efficiencies", shown(cell)))
                .expected(names())
                .nearest(cell, COLUMNS.iter().map(|(name, _)| *name))
        })?;
        if columns.contains(known) {
            return Err(Error::new(at(), format!("the column `{cell}` is there twice")));
        }
        columns.push(*known);
    }
    let has = |column: Column| columns.iter().any(|(_, other)| *other == column);
    for column in [Column::Wavelength, Column::Angle, Column::Order] {
        if !has(column) {
            let name = COLUMNS.iter().find(|(_, other)| *other == column).map_or("", |(name, _)| name);
            return Err(Error::new(at(), format!("efficiencies without a column `{name}`")).expected(names()));
        }
    }
    let mut any = false;
    for (letter, share) in [("T", Column::Transmittance as fn(Of) -> Column), ("R", Column::Reflectance)] {
        let there = [Of::Both, Of::S, Of::P].map(|of| has(share(of)));
        any |= there[0] || there[1];
        if !matches!(there, [_, false, false] | [false, true, true]) {
            return Err(Error::new(at(), format!("efficiencies with other columns of {letter} than they may have"))
                .expected(format!("`{letter}`, or both `{letter}_s` and `{letter}_p`, or none of them")));
        }
    }
    if !any {
        return Err(Error::new(at(), "efficiencies without a column of T or R").expected(names()));
    }
    Ok(columns)
}

/// One line.
fn row(columns: &[(&'static str, Column)], said: &str, line: usize, at: &dyn Fn() -> Where) -> Result<Row> {
    let count = cells(said).len();
    if count != columns.len() {
        let wanted: Vec<&str> = columns.iter().map(|(name, _)| *name).collect();
        return Err(Error::new(at(), format!("`{}` has {count} values", shown(said))).expected(format!(
            "{} values: {}",
            columns.len(),
            wanted.join(", ")
        )));
    }
    let mut row = Row { line, back: false, order: 0, at: [0.0; 3], value: Efficiency::NONE };
    for ((name, column), cell) in columns.iter().zip(cells(said)) {
        if *column == Column::Side {
            row.back = match cell {
                "front" => false,
                "back" => true,
                other => {
                    return Err(Error::new(at(), format!("`side` is `{}`", shown(other)))
                        .expected("front or back, where the light arrives")
                        .nearest(other, ["front", "back"]));
                }
            };
            continue;
        }
        let range = |low: f64, high: f64| -> Result<f64> {
            let number = cell.parse::<f64>().ok().filter(|number| (low..=high).contains(number));
            // Programs write −0, too.
            number.map(|number| number + 0.0).ok_or_else(|| {
                Error::new(at(), format!("`{name}` is `{}`", shown(cell)))
                    .expected(format!("a number from {low} to {high}"))
            })
        };
        let shares = |share: f64, of: Of, to: &mut [f64; 2]| match of {
            Of::Both => *to = [share; 2],
            Of::S => to[0] = share,
            Of::P => to[1] = share,
        };
        match column {
            Column::Wavelength => row.at[0] = range(1.0, 1e6)?,
            Column::Angle => row.at[1] = range(-90.0, 90.0)?,
            Column::Conical => row.at[2] = range(0.0, 90.0)?,
            Column::Order => {
                row.order = cell.parse().map_err(|_| {
                    Error::new(at(), format!("`order` is `{}`", shown(cell))).expected("a whole number")
                })?;
            }
            Column::Side => {}
            Column::Transmittance(of) => shares(range(0.0, 1.0)?, *of, &mut row.value.transmittance),
            Column::Reflectance(of) => shares(range(0.0, 1.0)?, *of, &mut row.value.reflectance),
        }
    }
    Ok(row)
}

/// The lines of a side (of both where the table tells none apart) as a grid.
fn grid(mut rows: Vec<Row>, orders: &[i32], (by_side, back): (bool, bool), file: &Path) -> Result<EfficiencyGrid> {
    let here = |line: usize| Where::Line { file: file.to_owned(), line };
    let side = match (by_side, back) {
        (false, _) => "",
        (true, false) => " at the front",
        (true, true) => " at the back",
    };
    let axis = |k: usize| {
        let mut all: Vec<f64> = rows.iter().map(|row| row.at[k]).collect();
        all.sort_by(f64::total_cmp);
        all.dedup();
        all
    };
    let [nm, angle, conical] = [0, 1, 2].map(axis);
    let places = |a: &Row, b: &Row| {
        let by_angle = a.at.iter().zip(&b.at).map(|(a, b)| a.total_cmp(b)).find(|order| order.is_ne());
        a.order.cmp(&b.order).then(by_angle.unwrap_or(std::cmp::Ordering::Equal))
    };
    rows.sort_by(|a, b| places(a, b).then(a.line.cmp(&b.line)));
    if let Some([first, second]) = rows.windows(2).find_map(|pair| match pair {
        [a, b] => places(a, b).is_eq().then_some([a, b]),
        _ => None,
    }) {
        return Err(Error::new(here(second.line), format!("a second line for {second}{side}"))
            .expected(format!("one of each: the first is line {}", first.line)));
    }
    // Both rise alike, so that the first difference is the first hole.
    let points = || {
        let directions = || angle.iter().flat_map(|angle| conical.iter().map(move |conical| [*angle, *conical]));
        nm.iter().flat_map(move |nm| directions().map(move |[angle, conical]| [*nm, angle, conical]))
    };
    let mut own = rows.iter();
    for order in orders {
        if rows.is_empty() {
            return Err(Error::new(Where::file(file), format!("the table of efficiencies has no lines{side}"))
                .expected("lines of both sides, or no column `side`"));
        }
        for at in points() {
            if own.next().is_none_or(|row| (row.order, row.at) != (*order, at)) {
                let missing = Row { line: 0, back, order: *order, at, value: Efficiency::NONE };
                let size = format!("{} wavelengths x {} angles", nm.len(), angle.len() * conical.len());
                return Err(Error::new(Where::file(file), format!("no line for {missing}{side}"))
                    .expected(format!("one for each order at each of {size}")));
            }
        }
    }
    let grid = EfficiencyGrid {
        nm: nm.clone(),
        angle: angle.iter().map(|angle| angle.to_radians()).collect(),
        conical: conical.iter().map(|conical| conical.to_radians()).collect(),
        values: rows.iter().map(|row| row.value).collect(),
    };
    let count = grid.points();
    for point in 0..count {
        let sums = grid.sums(point);
        let too_much = sums.iter().zip(["s", "p"]).find(|(sum, _)| **sum > 1.0 + Grating::ROUNDED);
        if let Some((sum, name)) = too_much
            && let Some(last) = rows.iter().skip(point).step_by(count).max_by_key(|row| row.line)
        {
            let [nm, angle, _] = last.at;
            let what = format!("the orders together have {sum} of {name}-polarised light of {nm} nm at {angle}°{side}");
            return Err(Error::new(here(last.line), what).expected("at most 1").code(Code::ScatterGainsEnergy));
        }
    }
    Ok(grid)
}

#[cfg(test)]
mod tests {
    use super::*;
    use eyebox_scene::efficiency_table::Incidence;

    fn read(text: &str) -> Result<EfficiencyTable> {
        efficiency_table(text.as_bytes(), Path::new("g.csv"), &Where::Nowhere)
    }

    #[test]
    fn columns_stand_in_any_order() {
        let table = read(
            "\u{feff}# by hand\norder;angle_deg;wavelength_nm;T_s;T_p;R;side\r\n\
             -1;-10;550;0.5;0.25;0.1;front # a comment\n-1;10;550;0;0.125;0;front\n\n\
             0;-10;550;0;0;0;front\n0;10;550;0;0;0;front\n0;0;500;0.7;0.7;0.3;back\n-1;0;500;0;0;0;back\n",
        )
        .unwrap();
        assert_eq!(table.orders, [-1, 0]);
        let at = |order: usize, degrees: f64, front: bool| {
            table.at(order, &Incidence { nm: 550.0, across: degrees.to_radians().sin(), along: 0.0, front })
        };
        assert_eq!(at(0, -10.0, true), Efficiency { transmittance: [0.5, 0.25], reflectance: [0.1; 2] });
        let middle = at(0, 0.0, true);
        assert!((middle.transmittance[1] - 0.1875).abs() < 1e-15 && (middle.reflectance[0] - 0.05).abs() < 1e-15);
        assert_eq!(at(1, 50.0, false), Efficiency::even(0.7, 0.3));
        let alike = read("wavelength_nm\tangle_deg\torder\tconical_deg\tT\n550\t0\t1\t0\t1\n550\t0\t1\t30\t0").unwrap();
        assert_eq!((alike.back.is_none(), alike.front.conical.len()), (true, 2));
        let zeros = read(
            "wavelength_nm,angle_deg,order,conical_deg,T\n550,-0.0,1,0,1\n550,0,1,30,0\n550,5,1,-0,1\n550,5,1,30,0",
        )
        .unwrap();
        assert_eq!((zeros.front.angle.len(), zeros.front.conical.len()), (2, 2));
    }

    #[test]
    fn faults_are_one_line() {
        const HEAD: &str = "wavelength_nm,angle_deg,order,T_s,T_p\n";
        for (text, fault) in [
            ("", "g.csv: the table of efficiencies is empty; expected columns of wavelength_nm, "),
            ("wavelength_nm,angle,order,T", "g.csv:1: `angle` is no column of efficiencies; expected columns of "),
            ("wavelength_nm,order,T", "g.csv:1: efficiencies without a column `angle_deg`"),
            ("wavelength_nm,angle_deg,order,T,T", "g.csv:1: the column `T` is there twice"),
            ("wavelength_nm,angle_deg,order,T,T_s,T_p", "g.csv:1: efficiencies with other columns of T than"),
            ("wavelength_nm,angle_deg,order,R_p", "g.csv:1: efficiencies with other columns of R than"),
            ("wavelength_nm,angle_deg,order,side", "g.csv:1: efficiencies without a column of T or R"),
            (HEAD, "g.csv:1: the table of efficiencies has 0 orders; expected 1 to 64"),
            ("HEAD550,0,1,0.5", "g.csv:2: `550,0,1,0.5` has 4 values; expected 5 values: wavelength_nm, "),
            ("HEAD550,0,1.5,0.5,0.5", "g.csv:2: `order` is `1.5`; expected a whole number"),
            ("HEAD550,91,1,0.5,0.5", "g.csv:2: `angle_deg` is `91`; expected a number from -90 to 90"),
            ("HEADnan,0,1,0.5,0.5", "g.csv:2: `wavelength_nm` is `nan`; expected a number from 1 to 1000000"),
            ("HEAD550,0,1,0.5,inf", "g.csv:2: `T_p` is `inf`; expected a number from 0 to 1"),
            (
                "HEAD550,0,1,0.5,0.5\n\n550,0.0,1,0.5,0.5",
                "g.csv:4: a second line for order 1, 550 nm, 0°; expected one of each: the first is line 2",
            ),
            (
                "HEAD550,0,1,0.5,0.5\n550,5,1,0,0\n550,0,0,0,0",
                "g.csv: no line for order 0, 550 nm, 5°; expected one for each order at each of 1 wavelengths x 2 angles",
            ),
            ("HEAD550,0,1,0.5,0.5\n500,5,1,0,0", "g.csv: no line for order 1, 500 nm, 0°"),
            (
                "HEAD550,0,0,0.5,0.6\n550,0,1,0.5,0.5",
                "g.csv:3: the orders together have 1.1 of p-polarised light of 550 nm at 0°; expected at most 1",
            ),
            (
                "wavelength_nm,angle_deg,order,side,T\n550,0,1,front,0.5",
                "g.csv: the table of efficiencies has no lines at the back; expected lines of both sides, or no column `side`",
            ),
            (
                "wavelength_nm,angle_deg,order,side,T\n550,0,1,Front,0.5",
                "g.csv:2: `side` is `Front`; expected front or back",
            ),
        ] {
            let got = read(&text.replace("HEAD", HEAD)).unwrap_err().to_string();
            assert!(got.starts_with(fault) && !got.contains('\n'), "{got}");
        }
        let binary = efficiency_table(&[0xff, 0xfe, 0], Path::new("g.csv"), &Where::Nowhere).unwrap_err().to_string();
        assert!(binary.contains("g.csv are not a text"), "{binary}");
        let orders: String = (0..65).map(|order| format!("550,0,{order},0,0\n")).collect();
        assert!(read(&format!("{HEAD}{orders}")).unwrap_err().to_string().contains("has 65 orders"));
    }
}
