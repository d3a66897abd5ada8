//! Splits an Abaqus input file into keyword lines and the data lines below them.
//!
//! Comments (`**`) and blank lines vanish here, and a line that ends with a comma is joined with the next where
//! the format says so.

use std::borrow::Cow;

use crate::error::Fault;
use crate::names;

/// The parameters of the keywords that are read, without blanks. Those of them that nobody asks for do not change the mesh.
const PARAMETERS: [(&str, &[&str]); 6] = [
    ("NODE", &["INPUT", "INTERNAL", "NSET", "SYSTEM"]),
    ("ELEMENT", &["ELSET", "FILE", "INPUT", "INTERNAL", "OFFSET", "TYPE"]),
    ("NSET", &["ELSET", "GENERATE", "INSTANCE", "INTERNAL", "NSET", "UNSORTED"]),
    ("ELSET", &["ELSET", "GENERATE", "INSTANCE", "INTERNAL", "UNSORTED"]),
    (
        "SURFACE",
        &[
            "COMBINE",
            "CROP",
            "DEFINITION",
            "FILLETRADIUS",
            "INTERNAL",
            "MAXRATIO",
            "NAME",
            "NOOFFSET",
            "NOTHICK",
            "PROPERTY",
            "REGIONTYPE",
            "SCALETHICK",
            "TRIM",
            "TYPE",
        ],
    ),
    ("INSTANCE", &["NAME", "PART"]),
];

/// Keywords that are read or refused, as far as others are not near to them.
const OF_A_MESH: [&str; 19] = [
    "NODE",
    "ELEMENT",
    "NSET",
    "ELSET",
    "SURFACE",
    "PART",
    "ENDPART",
    "ASSEMBLY",
    "ENDASSEMBLY",
    "INSTANCE",
    "ENDINSTANCE",
    "INCLUDE",
    "SYSTEM",
    "NGEN",
    "NFILL",
    "NCOPY",
    "NMAP",
    "ELGEN",
    "ELCOPY",
];

/// A keyword line such as `*ELEMENT, TYPE=S4, ELSET=Plate`.
pub(super) struct Keyword {
    pub at: usize,
    /// In upper case, without the asterisk and without blanks, which do not count.
    pub name: String,
    /// Names in upper case without blanks, which do not count; values as written, without quotation marks.
    parameters: Vec<(String, Option<String>)>,
    text: String,
}

impl Keyword {
    fn parse(at: usize, text: &str) -> Self {
        let mut fields = split_outside_quotes(text).into_iter();
        let name = unspaced(fields.next().unwrap_or_default().trim_start_matches('*'));
        let parameters = fields
            .filter(|field| !field.trim().is_empty())
            .map(|field| match field.split_once('=') {
                Some((key, value)) => (unspaced(key), Some(unquoted(value).to_string())),
                None => (unspaced(field), None),
            })
            .collect();
        Self { at, name, parameters, text: text.to_string() }
    }

    /// Refuses a name that is none of a mesh but near to one or its beginning: passed over it would leave something out.
    pub fn refuse_slip(&self) -> Result<(), Fault> {
        if OF_A_MESH.contains(&self.name.as_str()) {
            return Ok(());
        }
        let begun = OF_A_MESH.into_iter().find(|name| self.name.len() > 3 && name.starts_with(&self.name));
        match begun.or_else(|| names::nearest(&self.name, OF_A_MESH)) {
            Some(meant) => Err(Fault::unexpected(self.at, format!("*{meant}"), format!("*{}", self.name))),
            None => Ok(()),
        }
    }

    /// The same with its parameters spelled out, which may be written as far as only one begins so. An unknown one is an error: it
    /// could change what is meant. It may also be the first data line, below a keyword line that ends with a comma.
    pub fn spelled_out(mut self) -> Result<Self, Fault> {
        let Some((_, known)) = PARAMETERS.iter().find(|(name, _)| *name == self.name) else {
            return Ok(self);
        };
        for (written, _) in &mut self.parameters {
            let mut alike = known.iter().filter(|name| name.starts_with(written.as_str()));
            *written = match (known.contains(&written.as_str()), alike.next(), alike.next()) {
                (true, ..) => continue,
                (false, Some(only), None) => (*only).into(),
                _ => {
                    let expected = format!("parameters of *{} ({})", self.name, known.join(", "));
                    return Err(Fault::unexpected(self.at, expected, written.as_str()));
                }
            };
        }
        Ok(self)
    }

    /// Whether the parameter is present, with or without a value.
    pub fn has(&self, parameter: &str) -> bool {
        self.parameters.iter().any(|(key, _)| key == parameter)
    }

    /// The value of a parameter.
    pub fn value(&self, parameter: &str) -> Option<&str> {
        self.parameters
            .iter()
            .find(|(key, _)| key == parameter)?
            .1
            .as_deref()
            .filter(|value| !value.is_empty())
    }

    /// The value of a parameter that must be there.
    pub fn required(&self, parameter: &str) -> Result<&str, Fault> {
        self.value(parameter).ok_or_else(|| {
            Fault::unexpected(self.at, format!("*{} with {parameter}=", self.name), &self.text)
        })
    }
}

/// The fields of a data line, trimmed.
pub(super) struct Data {
    pub at: usize,
    pub fields: Vec<String>,
    /// Number of the first field of each line that continues it, and the place of that line.
    continued: Vec<(usize, usize)>,
}

impl Data {
    /// The place of a field's line.
    pub fn place(&self, field: usize) -> usize {
        let line = self.continued.iter().rfind(|&&(first, _)| first <= field);
        line.map_or(self.at, |&(_, at)| at)
    }

    fn extend(&mut self, more: Data) {
        self.continued.push((self.fields.len(), more.at));
        self.fields.extend(more.fields);
    }
}

/// The lines of a file, read in order.
pub(super) struct Lines<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl<'a> Lines<'a> {
    pub fn new(bytes: &'a [u8]) -> Self {
        let mark: &[u8] = b"\xef\xbb\xbf";
        Self { bytes, at: if bytes.starts_with(mark) { mark.len() } else { 0 } }
    }

    /// The next keyword line. A data line is an error: data is read below its keyword.
    pub fn keyword(&mut self) -> Result<Option<Keyword>, Fault> {
        let Some((at, line)) = self.next() else { return Ok(None) };
        if !line.starts_with('*') {
            return Err(Fault::unexpected(at, "a keyword line (begins with *)", line.as_bytes()));
        }
        let mut text = line.into_owned();
        while text.ends_with(',') {
            match self.next_if(|line| !line.starts_with('*')) {
                Some((_, more)) => text.push_str(&more),
                None => break,
            }
        }
        Ok(Some(Keyword::parse(at, &text)))
    }

    /// The next data line below the present keyword.
    pub fn data(&mut self) -> Option<Data> {
        let (at, line) = self.next_if(|line| !line.starts_with('*'))?;
        Some(Data {
            at,
            fields: split_outside_quotes(&line).into_iter().map(|f| unquoted(f).into()).collect(),
            continued: Vec::new(),
        })
    }

    /// Passes over the data lines below the present keyword.
    pub fn skip_data(&mut self) {
        while self.next_if(|line| !line.starts_with('*')).is_some() {}
    }

    /// The next data line with those that continue it: while a line ends with a comma, the next one does.
    pub fn open_record(&mut self) -> Option<Data> {
        let mut record = self.data()?;
        while record.fields.last().is_some_and(String::is_empty) {
            record.fields.pop();
            match self.data() {
                Some(more) => record.extend(more),
                None => break,
            }
        }
        Some(record)
    }

    /// The next data line, of `count` fields, or up to so many `more`. While fields are missing and the line ends with a comma, the
    /// next line continues it.
    pub fn record(&mut self, count: usize, more: usize, form: &str) -> Result<Option<Data>, Fault> {
        let Some(mut record) = self.data() else { return Ok(None) };
        while record.fields.last().is_some_and(String::is_empty) {
            record.fields.pop();
            if record.fields.len() >= count {
                break;
            }
            match self.data() {
                Some(more) => record.extend(more),
                None if self.at == self.bytes.len() => return Err(Fault::truncated(self.at, form)),
                None => break,
            }
        }
        if record.fields.len() < count {
            let form = format!("{form} (a line that goes on has to end with a comma)");
            return Err(Fault::unexpected(record.at, form, record.fields.join(", ")));
        }
        if record.fields.len() > count + more {
            return Err(Fault::unexpected(record.at, form, record.fields.join(", ")));
        }
        Ok(Some(record))
    }

    /// The next line that is neither blank nor a comment, trimmed, with its position.
    fn next(&mut self) -> Option<(usize, Cow<'a, str>)> {
        while self.at < self.bytes.len() {
            let start = self.at;
            let rest = &self.bytes[start..];
            let length = rest.iter().position(|&byte| byte == b'\n').unwrap_or(rest.len());
            self.at = (start + length + 1).min(self.bytes.len());
            let line = rest[..length].trim_ascii();
            if !line.is_empty() && !line.starts_with(b"**") {
                return Some((start, String::from_utf8_lossy(line)));
            }
        }
        None
    }

    fn next_if(&mut self, condition: impl Fn(&str) -> bool) -> Option<(usize, Cow<'a, str>)> {
        let before = self.at;
        let line = self.next();
        match line {
            Some((_, text)) if !condition(&text) => {
                self.at = before;
                None
            }
            other => other,
        }
    }
}

fn split_outside_quotes(text: &str) -> Vec<&str> {
    let mut quoted = false;
    text.split(|character| {
        quoted ^= character == '"';
        character == ',' && !quoted
    })
    .collect()
}

fn unquoted(text: &str) -> &str {
    let text = text.trim();
    text.strip_prefix('"').and_then(|inner| inner.strip_suffix('"')).unwrap_or(text)
}

fn unspaced(text: &str) -> String {
    text.split_whitespace().collect::<String>().to_uppercase()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keywords_ignore_case_spaces_and_comments_and_continue_after_a_comma() {
        let mut lines =
            Lines::new(b"** a comment\r\n\n*Element,  type = S4r,\r\n** another\n elset=\"My, Set\"\n1,2\n");
        let keyword = lines.keyword().unwrap().unwrap();
        assert_eq!(keyword.name, "ELEMENT");
        assert_eq!(keyword.value("TYPE"), Some("S4r"));
        assert_eq!(keyword.value("ELSET"), Some("My, Set"));
        assert!(keyword.required("NSET").is_err());
        assert_eq!(lines.data().unwrap().fields, ["1", "2"]);
        assert!(lines.data().is_none());
        assert!(lines.keyword().unwrap().is_none());
    }

    #[test]
    fn keywords_of_other_things_are_no_slips() {
        let others = "AMPLITUDE, BEAM SECTION, BOUNDARY, BUCKLE, BULK VISCOSITY, CFLUX, CHANGE FRICTION, CLEARANCE, CLOAD, \
            COHESIVE SECTION, CONDUCTIVITY, CONNECTOR SECTION, CONSTRAINT CONTROLS, CONTACT, CONTACT FILE, CONTACT INCLUSIONS, \
            CONTACT PAIR, CONTACT PRINT, CONTROLS, COUPLED TEMPERATURE-DISPLACEMENT, COUPLING, CREEP, CYCLIC SYMMETRY MODEL, \
            DAMPING, DASHPOT, DENSITY, DEPVAR, DISTRIBUTING, DISTRIBUTION, DLOAD, DSLOAD, DYNAMIC, EL FILE, EL PRINT, ELASTIC, \
            ELEMENT OUTPUT, ELEMENT RESPONSE, EMBEDDED ELEMENT, END LOAD CASE, END STEP, ENERGY OUTPUT, EQUATION, EXPANSION, \
            FASTENER, FILE FORMAT, FILM, FILTER, FLUID BEHAVIOR, FREQUENCY, FRICTION, GAP, GASKET SECTION, HEADING, HEAT TRANSFER, \
            HYPERELASTIC, HYPERFOAM, IMPEDANCE, IMPORT CONTROLS, IMPORT ELSET, IMPORT NSET, INELASTIC HEAT FRACTION, INERTIA \
            RELIEF, INITIAL CONDITIONS, INTEGRATED OUTPUT, KINEMATIC, LATENT HEAT, LOAD CASE, MAP SOLUTION, MASS, MASS FLOW RATE, \
            MATERIAL, MATRIX ASSEMBLE, MATRIX INPUT, MEMBRANE SECTION, MODAL DAMPING, MODEL CHANGE, MONITOR, MPC, NODAL ENERGY \
            RATE, NODAL THICKNESS, NODE FILE, NODE OUTPUT, NODE PRINT, NODE RESPONSE, NONSTRUCTURAL MASS, NORMAL, ORIENTATION, \
            OUTPUT, PARAMETER, PHYSICAL CONSTANTS, PLASTIC, POST OUTPUT, PREPRINT, PRESTRESS HOLD, PRE-TENSION SECTION, PRINT, \
            RADIATE, RATE DEPENDENT, REBAR LAYER, RELEASE, RESTART, RIGID BODY, ROTARY INERTIA, SECTION CONTROLS, SECTION PRINT, \
            SFILM, SHELL GENERAL SECTION, SHELL SECTION, SHELL TO SOLID COUPLING, SLIDE LINE, SOLID SECTION, SPECIFIC HEAT, \
            SPRING, SRADIATE, STATIC, STEP, SUBMODEL, SUBSTRUCTURE PATH, SURFACE BEHAVIOR, SURFACE INTERACTION, SURFACE \
            PROPERTY, SURFACE SECTION, SURFACE SMOOTHING, SYMMETRIC RESULTS TRANSFER, TEMPERATURE, TIE, TIME POINTS, TRANSFORM, \
            TRANSVERSE SHEAR STIFFNESS, UEL PROPERTY, USER ELEMENT, USER MATERIAL, VARIABLE MASS SCALING, VIEWFACTOR, VISCO, \
            VISCOELASTIC, WIND";
        for other in others.split(", ") {
            assert!(Keyword::parse(0, &format!("*{other}")).refuse_slip().is_ok(), "{other}");
        }
    }

    #[test]
    fn records_gather_continued_lines() {
        let mut lines = Lines::new(b"1, 2,\n3, 4,\n5,\n6, 7, 8\n9, 10\n11,");
        let mut record = || lines.record(4, 0, "four numbers");
        assert_eq!(record().unwrap().unwrap().fields, ["1", "2", "3", "4"]);
        assert_eq!(record().unwrap().unwrap().fields, ["5", "6", "7", "8"]);
        assert!(record().is_err());
        assert!(record().is_err());
        assert!(record().unwrap().is_none());
    }
}
