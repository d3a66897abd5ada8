//! How an interface pairs and evaluates.

use std::mem::offset_of;

use runtime::interface::{ContactElement, InterfaceOptions};
use runtime::neighbourhood::{NeighbourRule, SearchOptions};
use runtime::surface::Facet;

use crate::border::{self, Versioned, read_sized, reserved, sized_target};
use crate::choice::{self, Named, dc_element_kind, dc_frame, dc_rule};
use crate::status::{DC_BAD_OPTION, Failure, dc_status};

/// How an interface pairs and evaluates. Set `size`, call dc_options_default, change what is to be different:
///
///     dc_options options = {.size = sizeof options};
///     dc_options_default(&options);
///     options.areas = 1;
///
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct dc_options {
    /// sizeof(dc_options).
    pub size: usize,
    /// dc_element_kind. Default: DC_DIFFUSE.
    pub element: i32,
    /// dc_weight. Default: DC_CUBIC.
    pub weight: i32,
    /// dc_frame: DC_CO_MOVING, or DC_HELD with another rule than DC_DOMAINS. Default: DC_CO_MOVING.
    pub frame: i32,
    /// dc_rule. dc_pair, which has no surface, takes DC_DOMAINS for DC_HULL_LAYERS. Default: DC_DOMAINS.
    pub rule: i32,
    /// Hull layers to start with; 0 for as many as make the fit well conditioned. Default: 0.
    pub layers: i32,
    /// Hull layers to stop at. Default: 6.
    pub max_layers: i32,
    /// Nodes to start with, by DC_NEAREST. Default: 12.
    pub nearest: i32,
    /// Nodes to stop at, by DC_NEAREST. Default: 24.
    pub max_nearest: i32,
    /// Nearest nodes among which hull layers are sought. Default: 48.
    pub candidates: i32,
    /// Up to how many they are doubled. Default: 192.
    pub max_candidates: i32,
    /// dc_basis. Default: DC_QUADRATIC.
    pub basis: i32,
    /// Whether the linear basis may stand in for the quadratic one: 0 or 1. Default: 1.
    pub linear_fallback: i32,
    /// Whether contacts carry tributary areas, so that the penalty is one per area: 0 or 1. They need slave facets. Default: 0.
    pub areas: i32,
    /// 0.
    pub reserved: i32,
    /// The regularity of a fit has to exceed this, at least 0 and below 1; not with DC_DOMAINS. Default: 0.01.
    pub smallest_regularity: f64,
    /// Support radius over the distance of the farthest node, above 1; not with DC_DOMAINS. Default: 1.25.
    pub radius_factor: f64,
    /// Facets that meet at a larger angle belong to different sheets, degrees. Default: 45.
    pub feature_angle_degrees: f64,
    /// How far beyond the border a foot still counts, in heights of the facet. Default: 0.01.
    pub border_tolerance: f64,
    /// Slaves farther from the master are not paired, length. 0 for no limit; over faces for the extents of face and facet together, in self
    /// contact for two mean extents of a facet. Default: 0.
    pub distance_limit: f64,
    /// A penetration deeper than this fraction of the support radius makes dc_cutback suggest a smaller increment.
    /// Default: 0.25.
    pub cutback_penetration: f64,
}

// SAFETY: numbers, the first one is the size.
unsafe impl Versioned for dc_options {
    const NAME: &'static str = "dc_options";
    const FIRST: usize = offset_of!(Self, cutback_penetration) + 8;
}

impl dc_options {
    /// The defaults of the runtime.
    pub fn defaults() -> Self {
        let search = SearchOptions::default();
        let interface = InterfaceOptions::default();
        let (NeighbourRule::Nearest { count, max_count }, NeighbourRule::HullLayers { max_layers, .. }) =
            (SearchOptions::nearest().rule, NeighbourRule::hull_layers(None))
        else {
            unreachable!("each function returns its own rule")
        };
        Self {
            size: size_of::<Self>(),
            element: dc_element_kind::DC_DIFFUSE as i32,
            weight: runtime::Weight::default().number(),
            frame: dc_frame::DC_CO_MOVING as i32,
            rule: dc_rule::DC_DOMAINS as i32,
            layers: 0,
            max_layers: max_layers as i32,
            nearest: count as i32,
            max_nearest: max_count as i32,
            candidates: search.candidates as i32,
            max_candidates: search.max_candidates as i32,
            basis: search.basis.number(),
            linear_fallback: i32::from(search.linear_fallback),
            areas: i32::from(interface.areas),
            reserved: 0,
            smallest_regularity: search.smallest_regularity,
            radius_factor: search.radius_factor,
            feature_angle_degrees: interface.feature_angle_degrees,
            border_tolerance: interface.border_tolerance,
            distance_limit: interface.distance_limit.unwrap_or(0.0),
            cutback_penetration: 0.25,
        }
    }

    /// The caller's options, or the defaults where there are none.
    ///
    /// # Safety
    /// As [`read_sized`].
    pub unsafe fn read(options: *const Self) -> Result<Self, Failure> {
        if options.is_null() {
            return Ok(Self::defaults());
        }
        let options = unsafe { read_sized(options, Self::defaults)? };
        reserved("dc_options", options.reserved)?;
        Ok(options)
    }

    /// The neighbour search of an interface.
    pub fn search(&self) -> Result<SearchOptions, Failure> {
        let layers = Some(choice::count("layers", self.layers)?).filter(|&layers| layers > 0);
        let max_layers = choice::count("max_layers", self.max_layers)?;
        let nearest = choice::count("nearest", self.nearest)?;
        let max_nearest = choice::count("max_nearest", self.max_nearest)?;
        let rules = [
            (dc_rule::DC_HULL_LAYERS as i32, NeighbourRule::HullLayers { layers, max_layers }),
            (dc_rule::DC_HULL_RADIUS as i32, NeighbourRule::HullRadius { layers, max_layers }),
            (dc_rule::DC_NEAREST as i32, NeighbourRule::Nearest { count: nearest, max_count: max_nearest }),
            (dc_rule::DC_DOMAINS as i32, NeighbourRule::Domains),
        ];
        Ok(SearchOptions::default()
            .with_rule(choice::choose("rule", self.rule, &rules)?)
            .with_basis(choice::read(self.basis)?)
            .with_linear_fallback(choice::flag("linear_fallback", self.linear_fallback)?)
            .with_smallest_regularity(self.smallest_regularity)
            .with_radius_factor(self.radius_factor)
            .with_candidates(choice::count("candidates", self.candidates)?)
            .with_max_candidates(choice::count("max_candidates", self.max_candidates)?))
    }

    /// The neighbour search in nodes without a surface. There the default rule, and that of options written for interfaces, stands for
    /// hull layers.
    pub fn search_in_nodes(&self) -> Result<SearchOptions, Failure> {
        let rule =
            if self.rule == dc_rule::DC_DOMAINS as i32 { dc_rule::DC_HULL_LAYERS as i32 } else { self.rule };
        Self { rule, ..*self }.search()
    }

    /// As the runtime has them; it checks the ranges.
    pub fn interface(&self) -> Result<InterfaceOptions, Failure> {
        let diffuse = ContactElement::diffuse(self.search()?)
            .with_weight(choice::read(self.weight)?)
            .with_frame(choice::read(self.frame)?);
        let elements = [
            (dc_element_kind::DC_DIFFUSE as i32, diffuse),
            (dc_element_kind::DC_NODE_TO_FACET as i32, ContactElement::NodeToFacet),
        ];
        Ok(InterfaceOptions::default()
            .with_element(choice::choose("element", self.element, &elements)?)
            .with_feature_angle_degrees(self.feature_angle_degrees)
            .with_border_tolerance(self.border_tolerance)
            .with_distance_limit(Some(self.distance_limit).filter(|&limit| limit != 0.0))
            .with_areas(choice::flag("areas", self.areas)?))
    }

    /// The same, of an interface with these facets of the slave. Only areas need them: without, a penalty per area would be one per node.
    pub fn interface_beside(&self, slave_facets: &[Facet]) -> Result<InterfaceOptions, Failure> {
        let options = self.interface()?;
        if options.areas || slave_facets.is_empty() {
            return Ok(options);
        }
        let message =
            "invalid-option: there are slave_facets, which only areas need: set areas of dc_options to 1";
        Err(Failure::new(DC_BAD_OPTION, message))
    }

    /// Deepest penetration that is not too deep, in support radii.
    pub fn cutback_limit(&self) -> Result<f64, Failure> {
        let limit = self.cutback_penetration;
        if limit > 0.0 && limit.is_finite() {
            return Ok(limit);
        }
        let message = format!("invalid-option: cutback_penetration must be positive and finite, not {limit}");
        Err(Failure::new(DC_BAD_OPTION, message))
    }
}

/// Fills the options with their defaults; options.size has to be set before.
///
/// # Safety
/// `options` is NULL, or as many bytes as its field `size` says may be written there.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dc_options_default(options: *mut dc_options) -> dc_status {
    border::call(|| {
        unsafe { sized_target(options)?.write(&dc_options::defaults()) };
        Ok(())
    })
}
