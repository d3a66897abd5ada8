//! The build API: everything that reads or writes files.

use std::fmt;
use std::path::{Path, PathBuf};

use rustc_hash::FxHashSet;

use crate::contact::{EmitOptions, TooLong, emit_file};
use crate::emit::{MOST_STATEMENTS, c_constants, emit_c, emit_element, emit_element_test, test_module};
use crate::kernel::{ElementError, ElementKernels, ElementModel};
use crate::model::{Basis, BasisError, CustomBasis, FacetShape, Weight, WeightError};

/// Why kernels were not generated.
///
/// `Debug` prints the same text as `Display`: it is what one sees of an error that `main` of a build script returns.
#[derive(thiserror::Error)]
#[non_exhaustive]
#[allow(missing_docs)] // The messages say what the fields are.
pub enum ConfigError {
    /// A weight is not usable.
    #[error(transparent)]
    Weight(#[from] WeightError),
    /// A basis is not usable.
    #[error(transparent)]
    Basis(#[from] BasisError),
    /// The formulas of an element are not usable.
    #[error("the element \"{element}\": {source}")]
    Element { element: String, source: ElementError },
    /// An element has the name of another one or of a weight.
    #[error("two modules are named \"{name}\", one of them of an element")]
    DuplicateElement { name: String },
    /// A module that the generator names itself has the name of another one: that of weights which share kernels, or of an element's test.
    #[error(
        "two modules are named \"{name}\", one of them of weights that share kernels or of a test; change the other name"
    )]
    DuplicateModule { name: String },
    /// Two elements have names that differ in the case of letters only, which the C header does not tell apart.
    #[error(
        "the elements \"{name}\" and \"{other}\" have the same constants in the C header; change more than the case of letters"
    )]
    DuplicateInUpperCase { name: String, other: String },
    /// Two constants of the C header have one name: names of residuals that differ in the case of letters only, or that are joined alike.
    #[error("two constants of the C header are named {name}; change the name of an element or of a residual")]
    DuplicateConstant { name: String },
    /// Two tests are of one element.
    #[error("the element \"{name}\" has two tests; give it one")]
    DuplicateTest { name: String },
    /// Two bases have one name.
    #[error("two bases are named \"{name}\"")]
    DuplicateBasis { name: String },
    /// Two weights have one name.
    #[error("two weights are named \"{name}\"")]
    DuplicateWeight { name: String },
    /// Weights whose formulas make a function that rustc has no stack for. `weight` is the weight's name; of weights that share kernels all
    /// names, with `_or_` between them.
    #[error(
        "the weight \"{weight}\" is too long: its function {function} would have {statements} statements, at most \
         {MOST_STATEMENTS} can be compiled; shorten the formula, or do without `share_kernels` if several share the function"
    )]
    WeightTooLong { weight: String, function: String, statements: usize },
    /// A test of an element that there is not.
    #[error("there is no element \"{name}\" to be tested")]
    UnknownElement { name: String },
    /// The path of the support module is not a Rust path.
    #[error("\"{path}\" is not a Rust path")]
    SupportPath { path: String },
    /// `OUT_DIR` is not set and no output folder was given.
    #[error("OUT_DIR is not set: call this from a build script, or give an output folder")]
    NoOutputFolder,
    /// The file could not be written.
    #[error("cannot write {}: {source}", .path.display())]
    Write { path: PathBuf, source: std::io::Error },
}

impl fmt::Debug for ConfigError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}

impl From<TooLong> for ConfigError {
    fn from(TooLong { weight, function, statements }: TooLong) -> Self {
        Self::WeightTooLong { weight, function, statements }
    }
}

/// Which kernels to generate, and where to.
///
/// ```no_run
/// # fn main() -> Result<(), diffuse_contact_codegen::ConfigError> {
/// // build.rs
/// diffuse_contact_codegen::Config::new()
///     .weight("quartic", "(1 - r)^3 * (1 + 3*r)")?
///     .compile()?;
/// # Ok(())
/// # }
/// ```
///
/// The crate then has the kernels with
/// `include!(concat!(env!("OUT_DIR"), "/diffuse_contact_kernels.rs"));`, one module per weight.
#[derive(Clone, Debug)]
pub struct Config {
    /// In groups that share kernels.
    weights: Vec<Vec<Weight>>,
    bases: Vec<Basis>,
    elements: Vec<ElementKernels>,
    tests: Vec<ElementTest>,
    fit: bool,
    friction: bool,
    support: String,
    folder: Option<PathBuf>,
}

/// Inputs that an element is tested with.
#[derive(Clone, Debug)]
struct ElementTest {
    name: String,
    inputs: Vec<Vec<f64>>,
    nodes: Vec<Vec<f64>>,
}

impl Default for Config {
    fn default() -> Self {
        Self::new()
    }
}

impl Config {
    /// No weights and no facets yet; both built-in bases, quadratic and linear; output to `OUT_DIR`; support from the
    /// crate `diffuse-contact-kernels`.
    pub fn new() -> Self {
        Self {
            weights: Vec::new(),
            bases: Basis::ALL.to_vec(),
            elements: Vec::new(),
            tests: Vec::new(),
            fit: false,
            friction: false,
            support: "::diffuse_contact_kernels::support".to_owned(),
            folder: None,
        }
    }

    /// Adds the paper's cubic weight (14), in the module `cubic`.
    #[must_use]
    pub fn cubic(mut self) -> Self {
        self.weights.push(vec![Weight::cubic()]);
        self
    }

    /// Adds the cubic weight made interpolating (16), in the module `cubic_interpolating`.
    #[must_use]
    pub fn cubic_interpolating(mut self) -> Self {
        self.weights.push(vec![Weight::cubic_interpolating()]);
        self
    }

    /// Adds the C² weight (1 − r)⁴ (1 + 4r), in the module `wendland_c2`.
    #[must_use]
    pub fn wendland_c2(mut self) -> Self {
        self.weights.push(vec![Weight::wendland_c2()]);
        self
    }

    /// Adds the weight ω/(1 − ω) made from a formula ω in `r` that is 1 at r = 0 and below 1 elsewhere, in the module
    /// `name`: the fitted surface passes through the nodes (16).
    ///
    /// # Errors
    /// [`ConfigError::Weight`].
    pub fn interpolating(mut self, name: &str, formula: &str) -> Result<Self, ConfigError> {
        self.weights.push(vec![Weight::interpolating(name, formula)?]);
        Ok(self)
    }

    /// Adds a weight given by a formula in `r`, in the module `name`.
    ///
    /// # Errors
    /// [`ConfigError::Weight`], which for a formula that cannot be read points at the character.
    pub fn weight(mut self, name: &str, formula: &str) -> Result<Self, ConfigError> {
        self.weights.push(vec![Weight::new(name, formula)?]);
        Ok(self)
    }

    /// Lets all weights so far share kernels, but for the interpolating ones: compiles in less time and takes less
    /// room; a kernel evaluates all of the formulas, about 1 % more operations for two polynomials.
    #[must_use]
    pub fn share_kernels(mut self) -> Self {
        let (own, shared): (Vec<Weight>, Vec<Weight>) =
            self.weights.into_iter().flatten().partition(Weight::is_interpolating);
        let shared = (!shared.is_empty()).then_some(shared);
        self.weights = shared.into_iter().chain(own.into_iter().map(|weight| vec![weight])).collect();
        self
    }

    /// Adds a basis of the caller's to the built-in ones, for all weights: in each weight's module one more module
    /// `name`, and the constant `NAME`, a support `Basis` to evaluate elements with. Exponents of (a, b), in the order
    /// of their degrees, as [`CustomBasis::new`] takes them.
    ///
    /// # Errors
    /// [`ConfigError::Basis`], [`ConfigError::DuplicateBasis`].
    pub fn basis(mut self, name: &'static str, monomials: &'static [(u8, u8)]) -> Result<Self, ConfigError> {
        let basis = CustomBasis::new(name, monomials)?;
        if self.bases.iter().any(|other| other.name() == name) {
            return Err(ConfigError::DuplicateBasis { name: name.to_owned() });
        }
        self.bases.push(Basis::Custom(basis));
        Ok(self)
    }

    /// Adds the elements of contact on the facets themselves, in the modules `gap_over_triangle` and `gap_over_quadrilateral`.
    #[must_use]
    pub fn facets(mut self) -> Self {
        self.elements.extend(FacetShape::ALL.map(ElementKernels::facet));
        self
    }

    /// Adds an element of the caller's from its formulas, in the module `name`: `Inputs` and `Values` as they are declared,
    /// a function per number of derivatives for numbers and lanes, `evaluate` for one element and `batch` for many
    /// with the vector instructions of the machine. Derivatives are exact and nobody writes them:
    ///
    /// ```
    /// use diffuse_contact_codegen::expr::Vec3;
    /// use diffuse_contact_codegen::{Config, ConfigError};
    ///
    /// # fn main() -> Result<(), ConfigError> {
    /// let config = Config::new().element("spring", |m| {
    ///     let x: [Vec3; 2] = m.variable("x");
    ///     let [stiffness, length] = m.parameters(["stiffness", "length"]);
    ///     let stretch = (x[1] - x[0]).norm() - length;
    ///     m.energy(0.5 * stiffness * stretch.powi(2));
    /// })?;
    /// assert!(config.source()?.contains("pub mod spring"));
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// The formulas are called twice: what a test compares with is of sums and products as they are written. They may not depend on what an
    /// expression is simplified to.
    ///
    /// # Errors
    /// [`ConfigError::Element`], which names the element and the expression.
    pub fn element(mut self, name: &str, formulas: impl Fn(&ElementModel<'_>)) -> Result<Self, ConfigError> {
        let element = |source| ConfigError::Element { element: name.to_owned(), source };
        self.elements.push(ElementKernels::new(name, formulas).map_err(element)?);
        Ok(self)
    }

    /// Adds a test of an element to the crate, in the module `name_tests`: with these inputs `evaluate` and `batch` have the values and the
    /// derivatives of the interpreter, and those of automatic differentiation of the formulas as they are written, to 1e-12 of the largest entry,
    /// or to rounding of the largest of all results. `inputs` are the element's in the order of their declaration, each with its last dimension
    /// fastest; `nodes` has of each node all its inputs.
    ///
    /// ```
    /// # use diffuse_contact_codegen::expr::Vec3;
    /// # use diffuse_contact_codegen::{Config, ConfigError};
    /// # fn main() -> Result<(), ConfigError> {
    /// let config = Config::new()
    ///     .element("spring", |m| {
    ///         let x: [Vec3; 2] = m.variable("x");
    ///         m.energy(0.5 * m.parameter::<diffuse_contact_codegen::Expr>("stiffness") * (x[1] - x[0]).norm().powi(2));
    ///     })?
    ///     .test("spring", &[&[0.0, 0.0, 0.0, 1.0, 0.1, -0.2], &[3.0]], &[]);
    /// assert!(config.source()?.contains("mod spring_tests"));
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// Numbers that do not fit, and results that are not finite, are errors of [`compile`](Self::compile).
    #[must_use]
    pub fn test(mut self, name: &str, inputs: &[&[f64]], nodes: &[&[f64]]) -> Self {
        let [inputs, nodes] = [inputs, nodes].map(|rows| rows.iter().map(|row| row.to_vec()).collect());
        self.tests.push(ElementTest { name: name.to_owned(), inputs, nodes });
        self
    }

    /// Adds the kernels of the fit by itself for all weights and bases: coefficients, and the surface at a point, with their
    /// derivatives. The gap needs none of them.
    #[must_use]
    pub const fn fit(mut self) -> Self {
        self.fit = true;
        self
    }

    /// Adds the kernels of contact with friction for all weights and bases: the slip from an anchor beside the gap, with its
    /// derivatives.
    #[must_use]
    pub const fn friction(mut self) -> Self {
        self.friction = true;
        self
    }

    /// Path of the support module the kernels use.
    #[must_use]
    pub fn support(mut self, path: &str) -> Self {
        path.clone_into(&mut self.support);
        self
    }

    /// Folder to write to instead of `OUT_DIR`.
    #[must_use]
    pub fn output_folder(mut self, folder: impl AsRef<Path>) -> Self {
        self.folder = Some(folder.as_ref().to_owned());
        self
    }

    /// The kernels' source text, for a crate compiled with optimisation.
    ///
    /// # Errors
    /// [`ConfigError::SupportPath`], [`ConfigError::DuplicateWeight`], [`ConfigError::WeightTooLong`],
    /// [`ConfigError::DuplicateElement`], [`ConfigError::DuplicateModule`], [`ConfigError::DuplicateTest`], [`ConfigError::UnknownElement`],
    /// [`ConfigError::Element`] of an element that is too long, or of numbers that it cannot be tested with.
    pub fn source(&self) -> Result<String, ConfigError> {
        self.source_for(true)
    }

    /// The kernels of the elements as a C99 header: for each number of derivatives a function for one element, and one for arrays of
    /// many.
    ///
    /// # Errors
    /// [`ConfigError::DuplicateElement`], [`ConfigError::DuplicateInUpperCase`], [`ConfigError::DuplicateConstant`].
    pub fn c_source(&self) -> Result<String, ConfigError> {
        self.check_elements()?;
        // Guards and constants are in upper case.
        for (k, name) in self.element_names().enumerate() {
            let mut before = self.element_names().take(k);
            if let Some(other) = before.find(|other| other.to_uppercase() == name.to_uppercase()) {
                let (name, other) = (name.clone(), other.clone());
                return Err(ConfigError::DuplicateInUpperCase { name, other });
            }
        }
        let text = emit_c(&self.elements);
        let mut constants = FxHashSet::default();
        let twice = c_constants(&text).find(|name| !constants.insert(*name)).map(str::to_owned);
        twice.map_or(Ok(text), |name| Err(ConfigError::DuplicateConstant { name }))
    }

    /// Whether elements have names of their own.
    fn check_elements(&self) -> Result<(), ConfigError> {
        let mut names: FxHashSet<&str> = self.weights.iter().flatten().map(Weight::name).collect();
        let twice = self.element_names().find(|name| !names.insert(name));
        twice.map_or(Ok(()), |name| Err(ConfigError::DuplicateElement { name: name.clone() }))
    }

    fn element_names(&self) -> impl Iterator<Item = &String> {
        self.elements.iter().map(|element| &element.signature.name)
    }

    /// Whether modules that are named after others have names of their own: those of weights that share kernels, and those of tests.
    fn check_modules(&self) -> Result<(), ConfigError> {
        let weights = self.weights.iter().flatten().map(|weight| weight.name().to_owned());
        let mut names: FxHashSet<String> = weights.chain(self.element_names().cloned()).collect();
        let groups = self.weights.iter().filter(|weights| weights.len() > 1);
        let mut shared = groups.filter_map(|weights| Some(Weight::either(weights)?.name().to_owned()));
        let twice = shared.find(|name| !names.insert(name.clone())).or_else(|| {
            let mut tests = self.tests.iter().map(|test| test_module(&test.name));
            tests.find(|name| names.contains(name))
        });
        twice.map_or(Ok(()), |name| Err(ConfigError::DuplicateModule { name }))
    }

    fn source_for(&self, optimised: bool) -> Result<String, ConfigError> {
        let support = syn::parse_str(&self.support)
            .map_err(|_| ConfigError::SupportPath { path: self.support.clone() })?;
        let names: Vec<&str> = self.weights.iter().flatten().map(Weight::name).collect();
        for (k, name) in names.iter().enumerate() {
            if names[..k].contains(name) {
                return Err(ConfigError::DuplicateWeight { name: (*name).to_owned() });
            }
        }
        let elements = || self.element_modules(&support, optimised);
        let Self { bases, fit, friction, .. } = self;
        let options = EmitOptions { support: &support, bases, fit: *fit, friction: *friction, optimised };
        emit_file(&self.weights, elements, options)
    }

    fn element_modules(
        &self,
        support: &syn::Path,
        optimised: bool,
    ) -> Result<Vec<proc_macro2::TokenStream>, ConfigError> {
        self.check_elements()?;
        self.check_modules()?;
        let mut all = Vec::new();
        for element in &self.elements {
            let name = &element.signature.name;
            let module = emit_element(element, support, optimised);
            all.push(module.map_err(|source| ConfigError::Element { element: name.clone(), source })?);
        }
        for (k, ElementTest { name, inputs, nodes }) in self.tests.iter().enumerate() {
            if self.tests[..k].iter().any(|test| test.name == *name) {
                return Err(ConfigError::DuplicateTest { name: name.clone() });
            }
            let element = self.elements.iter().find(|element| element.signature.name == *name);
            let element = element.ok_or_else(|| ConfigError::UnknownElement { name: name.clone() })?;
            let test = emit_element_test(element, support, inputs, nodes);
            all.push(test.map_err(|source| ConfigError::Element { element: name.clone(), source })?);
        }
        Ok(all)
    }

    /// Writes `diffuse_contact_kernels.rs` if its bytes change, and tells Cargo when to run again. Warnings are of a weight that does not
    /// end flat ([`Weight::note`]), and of inputs that no output of their element depends on. In a build script the kernels know whether
    /// their crate is compiled with optimisation, from Cargo's `OPT_LEVEL`: at level 0 or 1 they are compiled, and run, number by number,
    /// which takes a fifth of the time to compile.
    pub fn compile(&self) -> Result<PathBuf, ConfigError> {
        let folder = match &self.folder {
            Some(folder) => folder.clone(),
            None => std::env::var_os("OUT_DIR").map(PathBuf::from).ok_or(ConfigError::NoOutputFolder)?,
        };
        let path = folder.join("diffuse_contact_kernels.rs");
        let optimised = !std::env::var("OPT_LEVEL").is_ok_and(|level| level == "0" || level == "1");
        let source = self.source_for(optimised)?;
        if !std::fs::read(&path).is_ok_and(|old| old == source.as_bytes()) {
            std::fs::write(&path, source)
                .map_err(|source| ConfigError::Write { path: path.clone(), source })?;
        }
        for note in self.weights.iter().flatten().filter_map(Weight::note) {
            println!("cargo::warning={note}");
        }
        for element in &self.elements {
            let name = &element.signature.name;
            for input in element.unused_inputs() {
                println!("cargo::warning=element \"{name}\": no output depends on `{input}`");
            }
        }
        // The formulas are in the build script; Cargo rebuilds it when this crate changes.
        if Path::new("build.rs").exists() {
            println!("cargo::rerun-if-changed=build.rs");
        }
        Ok(path)
    }
}
