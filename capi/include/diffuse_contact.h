/* diffuse_contact.h: the diffuse contact element (Chamoret, Rassineux, Bergheau 2008) for C, C++ and Fortran.
 *
 * An interface is a master surface of facets, slave nodes, and their pairing:
 *
 *     dc_create                   positions, facets, slaves               once
 *     dc_create_self_contact      the same of a surface that touches itself
 *     dc_set_symmetry             planes in which everything is mirrored  once, if there are any
 *     dc_refresh                  who is paired with whom                 once an increment
 *     dc_follow, dc_evaluate      the positions of the moment             each iteration
 *     dc_add_forces               adds the contact forces
 *     dc_adaptive_tangent         which tangent: e N N^T far from equilibrium
 *     dc_pattern_fill             the tangent -dR/dx, or dc_triplets; dc_map_add into a matrix of the caller's
 *     dc_operator_product         products with it, without a matrix
 *     dc_cutback                  whether the increment had better be smaller
 *     dc_accept                   with friction: the increment has converged
 *     dc_augment                  with friction: sticking contacts do so whatever the tangential stiffness
 *     dc_destroy
 *
 * dc_faces_create, dc_faces_refresh, dc_faces_update, dc_faces_evaluate, dc_faces_add_forces, dc_faces_triplets, dc_faces_accept: the same
 * with contact integrated over the slave's faces, which passes the patch test.
 *
 * dc_pair, dc_gap, dc_gap_batch and dc_element_system serve single elements without an interface.
 *
 * Every call that can fail returns a dc_status; dc_message() is the sentence to it. The library copies what it is given and fills
 * arrays of the caller, whose sizes it checks; an array that is filled must not overlap another one of the call, unless it says so
 * (DC_BAD_POINTER). Indices count from 0. Lengths and forces are in the caller's units; g > 0 apart, g < 0 penetrating.
 *
 * Threads: calls without handle may be made from any number of threads at once. A handle serves one thread at a time; a second
 * one gets DC_BUSY. Evaluation runs in parallel inside; dc_set_threads or the environment variable RAYON_NUM_THREADS says in how many threads. A process
 * may fork while no thread of it is in a call: the child has copies of all handles and evaluates in threads of its own.
 *
 * Memory: a lack of it for results of an evaluation, equations, patterns, triplets or batches is DC_TOO_LARGE. A lack of it for tables of
 * the library's own, which dc_create and dc_refresh build, ends the process.
 *
 * Structures that open with `size` have it set to their sizeof before any call: dc_law law = {.size = sizeof law};
 *
 * Made from the sources in capi/src: do not edit.
 */


#ifndef DIFFUSE_CONTACT_H
#define DIFFUSE_CONTACT_H

#include <stddef.h>
#include <stdint.h>

// What became of a call. Everything but DC_OK, DC_FROZEN and DC_NO_CONTACT is for the caller to mend; unless the call says otherwise,
// nothing has changed then, neither behind the handle nor in the caller's arrays. dc_message() is the sentence to it.
typedef enum dc_status {
    // Done.
    DC_OK = 0,
    // dc_refresh or dc_follow of a frozen interface: the positions were taken over, the pairing was left as it is.
    DC_FROZEN = 1,
    // The element has no result; the outcome and the message say why. Not an error of the call.
    DC_NO_CONTACT = 2,
    // A pointer is NULL or not aligned, or two arrays overlap of which one is written.
    DC_BAD_POINTER = 3,
    // An array is too short, a count is not the one of the interface, or the field `size` of a structure is not that of
    // any version of it.
    DC_BAD_SIZE = 4,
    // The handle is not one of a live object: never made, or destroyed.
    DC_BAD_HANDLE = 5,
    // Another thread is in a call with this handle.
    DC_BUSY = 6,
    // An option or another number is out of its range, or none of the named ones.
    DC_BAD_OPTION = 7,
    // A position, a gap or another input is NaN, infinite or beyond 1e75.
    DC_NOT_FINITE = 8,
    // An index of a node or a slave is out of range.
    DC_OUT_OF_RANGE = 9,
    // The facets are no surface: a facet with equal nodes or without area, an edge with three facets, ...
    DC_BAD_SURFACE = 10,
    // A slave is listed twice, lies on the master, or has no slave facet although areas are asked for.
    DC_BAD_SLAVES = 11,
    // There is no pairing yet, or no evaluation at the positions and for the pairing of the moment, or one with too few derivatives.
    DC_NOT_EVALUATED = 12,
    // The pattern belongs to another pairing or to other equations: make a new one.
    DC_PATTERN_MISMATCH = 13,
    // A result is too large for a number. What was being summed holds anything.
    DC_OVERFLOW = 14,
    // No memory, or more of something than 32-bit indices can name.
    DC_TOO_LARGE = 15,
    // An error inside the library. The handle can only be destroyed. Please report it.
    DC_INTERNAL = 16,
} dc_status;

// Whether a slave node has a contact element with a result, and why not. Only DC_CONTACT comes with numbers.
typedef enum dc_outcome {
    // Gap, foot and normal are valid, and the derivatives asked for. A positive gap is no touch.
    DC_CONTACT = 0,
    // No facet was found for the slave in the last refresh.
    DC_NOT_PAIRED = 1,
    // Beyond distance_limit.
    DC_TOO_FAR = 2,
    // Too few masters on the slave's side of sharp edges, or masters that carry no fit.
    DC_NO_CANDIDATE = 3,
    // Never set: masters on a line or on a conic are DC_NO_CANDIDATE.
    DC_ILL_CONDITIONED = 4,
    // The foot lies beyond the border of the master, or beyond a sharp edge.
    DC_BEYOND_BORDER = 5,
    // The masters of the pairing no longer determine the surface, or too few of them are within reach: refresh.
    DC_SINGULAR_FIT = 6,
    // The iteration for the foot did not converge.
    DC_FOOT_DIVERGED = 7,
    // The foot lies outside the domain of influence.
    DC_FOOT_OUTSIDE = 8,
    // The slave lies on a centre of curvature: the foot is not unique.
    DC_CENTRE_OF_CURVATURE = 9,
    // The slave lies beyond one: the foot is not the nearest point.
    DC_BEYOND_CENTRE_OF_CURVATURE = 10,
    // The masters lie on a line or are as thick as wide.
    DC_NO_AVERAGE_PLANE = 11,
    // The direction that is to be outside lies in the plane of the masters.
    DC_AMBIGUOUS_OUTWARD = 12,
    // Node to facet: the facet has no normal at the foot.
    DC_DEGENERATE_FACET = 13,
    // The results are no numbers: coordinates too large or too small.
    DC_ELEMENT_OVERFLOW = 14,
    // dc_gap_batch only: the input of this element is refused. dc_gap says why.
    DC_REFUSED = 15,
    // With DC_DOMAINS: no place of the slave among the first positions of the masters was found, as near its centre of curvature.
    DC_NOT_MATERIAL_PLACE = 16,
    // The slave has a window of the master only, and its result may depend on what is not in it: make a new window.
    DC_BEYOND_WINDOW = 17,
    // Over faces and in self contact: no facet of the master lies over the faces around the node within the limit.
    DC_NOTHING_OVER = 18,
} dc_outcome;

// What the neighbour search had to give up for a contact.
typedef enum dc_fallback {
    // Nothing.
    DC_NO_FALLBACK = 0,
    // More layers or nodes than asked for.
    DC_EXTENDED = 1,
    // The linear basis: the gap is off by up to about k R^2/2 on a curvature k.
    DC_LINEAR_BASIS = 2,
} dc_fallback;

// How many derivatives are computed.
typedef enum dc_mode {
    // Gap, foot and normal.
    DC_VALUE = 0,
    // With the gradient N of the gap.
    DC_GRADIENT = 1,
    // With the Hessian M of the gap, too.
    DC_HESSIAN = 2,
} dc_mode;

// The element of every slave node.
typedef enum dc_element_kind {
    // The diffuse element: a smooth surface through the master nodes around the slave.
    DC_DIFFUSE = 0,
    // The classic element: the distance from the closest facet.
    DC_NODE_TO_FACET = 1,
} dc_element_kind;

// Weight function of the fit, r = distance from the slave over the support radius.
typedef enum dc_weight {
    // 1 - 3 r^2 + 2 r^3.
    DC_CUBIC = 0,
    // w/(1 - w) of the cubic weight w: the surface passes through the master nodes.
    DC_CUBIC_INTERPOLATING = 1,
    // (1 - r)^4 (1 + 4 r): the Hessian does not jump where a node leaves the support.
    DC_WENDLAND_C2 = 2,
} dc_weight;

// The frame of the fit.
typedef enum dc_frame {
    // The average plane of the masters, moving with them: N and M are the exact derivatives of the gap.
    DC_CO_MOVING = 0,
    // The average plane of the masters, held while differentiating. An interface holds that of the last refresh; with DC_DOMAINS, where
    // the plane is one with the slave's place, it is refused.
    DC_HELD = 1,
    // Directions given by the caller, held: dc_gap, and dc_gap_batch with one frame for all elements.
    DC_GIVEN = 2,
} dc_frame;

// Which master nodes take part.
typedef enum dc_rule {
    // Those of the first layers of convex hulls around the slave.
    DC_HULL_LAYERS = 0,
    // All within the radius that the layers set.
    DC_HULL_RADIUS = 1,
    // The nearest.
    DC_NEAREST = 2,
    // All nodes of the slave's sheet within whose domain of influence it lies, and their mirror images: a node enters and leaves with
    // weight zero, so the gap does not jump. Domains are ellipsoids around the positions of dc_create; the slave has a place there.
    // Only interfaces have the rule: domains belong to the nodes of a surface.
    DC_DOMAINS = 3,
} dc_rule;

// Polynomial basis of the fit.
typedef enum dc_basis {
    // 1, a, b: at least 3 masters.
    DC_LINEAR = 1,
    // 1, a, b, a^2, a b, b^2: at least 6 masters.
    DC_QUADRATIC = 2,
} dc_basis;

// What a contact with friction does.
typedef enum dc_friction_state {
    // There is no pressure, or no friction.
    DC_OPEN = 0,
    // The traction is below friction x pressure.
    DC_STICK = 1,
    // The traction is friction x pressure, against the slip.
    DC_SLIP = 2,
} dc_friction_state;

// The coefficient of Coulomb's friction.
typedef enum dc_coefficient {
    // A number.
    DC_CONSTANT = 0,
    // mu = mu_k + (mu_s - mu_k) exp(-decay x slip rate), from rest to fast sliding.
    DC_DECAYING = 1,
    // A table of pressures and slip rates.
    DC_TABULATED = 2,
    // A function of the caller's.
    DC_FUNCTION = 3,
} dc_coefficient;

// Which tangent is assembled.
typedef enum dc_tangent {
    // K = e N N^T - f M, the exact derivative of the force; indefinite in general. See dc_adaptive_tangent.
    DC_EXACT = 0,
    // K = e N N^T, positive semidefinite; needs no Hessian.
    DC_GAUSS_NEWTON = 1,
} dc_tangent;

// Where pressures of contact over faces follow from gaps.
typedef enum dc_face_pressures {
    // At the slave's nodes, from the average gap around each.
    DC_NODE_PRESSURES = 0,
    // At each integration point, from its own gap.
    DC_POINT_PRESSURES = 1,
} dc_face_pressures;

// Which triangle of a symmetric matrix is listed.
typedef enum dc_triangle {
    // Both.
    DC_FULL = 0,
    // Entries with row >= column.
    DC_LOWER = 1,
} dc_triangle;

// Contact over the faces of a slave: a master surface, slave faces, and the points that they are cut into. One thread at a time may use
// it, any thread; a second one gets DC_BUSY.
typedef struct dc_faces dc_faces;

// A contact interface: a master surface, slave nodes and their pairing. One thread at a time may use it, any thread; a
// second one gets DC_BUSY.
typedef struct dc_interface dc_interface;

// Where the tangent's entries go in the values of a matrix that the caller has, for a pairing. One thread at a time may use it, any thread.
typedef struct dc_map dc_map;

// The tangent K of an interface as an operator, at the positions it was made for: products without a matrix. One thread at a time may use
// it, any thread.
typedef struct dc_operator dc_operator;

// The facets of a master surface that a rank owns and those around them. One thread at a time may use it, any thread.
typedef struct dc_part dc_part;

// The places of the tangent's entries, for a pairing. One thread at a time may use it, any thread.
typedef struct dc_pattern dc_pattern;

// What some slaves can need of a master surface, by the numbers of the whole. One thread at a time may use it, any thread.
typedef struct dc_window dc_window;

// How an interface pairs and evaluates. Set `size`, call dc_options_default, change what is to be different:
//
//     dc_options options = {.size = sizeof options};
//     dc_options_default(&options);
//     options.areas = 1;
//
typedef struct dc_options {
    // sizeof(dc_options).
    size_t size;
    // dc_element_kind. Default: DC_DIFFUSE.
    int32_t element;
    // dc_weight. Default: DC_CUBIC.
    int32_t weight;
    // dc_frame: DC_CO_MOVING, or DC_HELD with another rule than DC_DOMAINS. Default: DC_CO_MOVING.
    int32_t frame;
    // dc_rule. dc_pair, which has no surface, takes DC_DOMAINS for DC_HULL_LAYERS. Default: DC_DOMAINS.
    int32_t rule;
    // Hull layers to start with; 0 for as many as make the fit well conditioned. Default: 0.
    int32_t layers;
    // Hull layers to stop at. Default: 6.
    int32_t max_layers;
    // Nodes to start with, by DC_NEAREST. Default: 12.
    int32_t nearest;
    // Nodes to stop at, by DC_NEAREST. Default: 24.
    int32_t max_nearest;
    // Nearest nodes among which hull layers are sought. Default: 48.
    int32_t candidates;
    // Up to how many they are doubled. Default: 192.
    int32_t max_candidates;
    // dc_basis. Default: DC_QUADRATIC.
    int32_t basis;
    // Whether the linear basis may stand in for the quadratic one: 0 or 1. Default: 1.
    int32_t linear_fallback;
    // Whether contacts carry tributary areas, so that the penalty is one per area: 0 or 1. They need slave facets. Default: 0.
    int32_t areas;
    // 0.
    int32_t reserved;
    // The regularity of a fit has to exceed this, at least 0 and below 1; not with DC_DOMAINS. Default: 0.01.
    double smallest_regularity;
    // Support radius over the distance of the farthest node, above 1; not with DC_DOMAINS. Default: 1.25.
    double radius_factor;
    // Facets that meet at a larger angle belong to different sheets, degrees. Default: 45.
    double feature_angle_degrees;
    // How far beyond the border a foot still counts, in heights of the facet. Default: 0.01.
    double border_tolerance;
    // Slaves farther from the master are not paired, length. 0 for no limit; over faces for the extents of face and facet together, in self
    // contact for two mean extents of a facet. Default: 0.
    double distance_limit;
    // A penetration deeper than this fraction of the support radius makes dc_cutback suggest a smaller increment.
    // Default: 0.25.
    double cutback_penetration;
} dc_options;

// What a refresh did, in numbers of slaves. paired = kept + renewed + changed + gained; with `without` it makes up all slaves.
typedef struct dc_report {
    // sizeof(dc_report), set by the caller.
    size_t size;
    // With a pairing now.
    int32_t paired;
    // Of these: with DC_DOMAINS, those whose list stays.
    int32_t kept;
    // Of these: paired anew with the same masters.
    int32_t renewed;
    // Of these: paired with other masters than before. The pattern of the tangent may be another one.
    int32_t changed;
    // Of these: without a pairing before.
    int32_t gained;
    // Without a pairing now, but with one before.
    int32_t lost;
    // Without a pairing now.
    int32_t without;
    // Pairings with more nodes than asked for.
    int32_t extended;
    // Pairings with the linear basis instead of the quadratic one.
    int32_t linear;
    // With a gap by the old pairing at these positions, but none by the new. Those that dc_follow lost in this way since the refresh before
    // count too, unless they have a gap again.
    int32_t contacts_lost;
    // With a gap now, but none by the old pairing.
    int32_t contacts_gained;
    // The node whose gap the refresh changed most; -1 if none.
    int32_t jump_node;
    // Of the contacts lost, the node with the smallest gap; -1 if none.
    int32_t lost_node;
    // Of the contacts gained, the node with the smallest gap; -1 if none.
    int32_t gained_node;
    // The gap of jump_node by the old pairing and by the new one.
    double jump_before;
    double jump_after;
    // The gap of lost_node by the old pairing, when it was lost.
    double lost_gap;
    // The gap of gained_node by the new pairing.
    double gained_gap;
    // Whether the pairings were made anew: 0 or 1. Patterns of before are still theirs where changed, gained and lost are 0. With DC_DOMAINS 0 while nothing has
    // moved by more than half the skin of the lists, with other rules always 1; 0 of a frozen interface.
    int32_t rebuilt;
    // Of those paired: deeper below the closest facet than a tenth of its size, the root of its area, when they were paired. If most are,
    // the master may be inside out.
    int32_t deep;
} dc_report;

// The contact of one slave. Without contact the numbers are 0, but for the area.
typedef struct dc_contact {
    // The slave node.
    int32_t node;
    // Number n of its masters; 0 if it is not paired.
    int32_t master_count;
    // dc_outcome.
    int32_t outcome;
    // dc_fallback.
    int32_t fallback;
    // Signed gap, length: positive apart, negative penetrating.
    double gap;
    // Foot on the master surface.
    double foot[3];
    // Unit normal of the surface there, outward.
    double normal[3];
    // Tributary area of the slave, length^2; 1 without areas.
    double area;
    // Support radius of the pairing, length; with DC_DOMAINS the shortest half axis of the domains of its list; node to facet: the extent
    // of the facet; 0 if it is not paired.
    double support_radius;
} dc_contact;

// A normal law of the caller's own. `pressure` has room for two numbers: p, force per area, or over nodes without areas force, and
// dp/dg, at the signed gap of a slave. `slave` is its place among the slaves, counted from 0, and not its node: see dc_slaves and
// dc_faces_slaves. A contact whose p is not positive is open. Friction of contacts that close in an increment takes p to begin at the
// gap 0.
//
// It is called from several threads at once, within any call that takes the law, and has to answer the same each time. It must return:
// no exception and no longjmp. What is no number is refused as that of a law.
typedef void (*dc_normal_law)(void *context, size_t slave, double gap, double *pressure);

// A coefficient of friction of the caller's own. `coefficient` has room for three numbers: mu, its derivative by the pressure and that by
// the slip rate. It is called as a dc_normal_law; of contacts that stick with the slip rate 0.
typedef void (*dc_friction_law)(void *context, double pressure, double rate, double *coefficient);

// The law of contact. With e = penalty x area:
//
//     f = lambda - e g          the contact is active if f > 0
//     R = f N                   force on the nodes
//     K = e N N^T - f M         = -dR/dx
//
// With friction R has the traction besides, at most friction x f and against the slip, and K its derivative, which is not symmetric
// where contacts slide or have just closed. Call dc_accept, or dc_faces_accept, before the first increment and after each that has
// converged: else contacts that carry force are refused with DC_NOT_EVALUATED.
//
// With a normal law by table, or of the caller's own, f = area x p(g), and -area x dp/dg stands in the place of e.
typedef struct dc_law {
    // sizeof(dc_law), set by the caller.
    size_t size;
    // Force per length, or per length^3 where contacts carry areas; positive.
    double penalty;
    // lambda of each slave, at least 0: the forces of the augmented Lagrangian. NULL for the penalty method.
    const double *multipliers;
    // Number of multipliers: of slaves, or 1 for a single element; 0 with NULL.
    size_t multiplier_count;
    // dc_tangent; 0 is DC_EXACT.
    int32_t tangent;
    // 0.
    int32_t reserved;
    // Coefficient of Coulomb's friction; 0 for none. Over faces it needs nothing else. At nodes it needs DC_NODE_TO_FACET, or DC_DIFFUSE with
    // DC_DOMAINS in a library built with it: see dc_accept. dc_element_system refuses it.
    double friction;
    // Tangential stiffness of contacts that stick, in the unit of the penalty; 0 for that of the penalty.
    double tangential_stiffness;
    // Traction that no contact exceeds, in the unit of the pressure: contacts slide at min(friction x f, shear_limit x area).
    // 0 for none.
    double shear_limit;
    // dc_coefficient; 0 is DC_CONSTANT, `friction`. A field of another coefficient that is set is DC_BAD_OPTION.
    int32_t coefficient;
    // Whether the history notes where contacts really stuck, so that dc_augment can take away what they creep by the tangential stiffness:
    // 0 or 1. Tractions are the same.
    int32_t augmented;
    // A normal law by table, in the place of the penalty's: ascending gaps, at least two, ...
    const double *normal_gaps;
    // ... and the pressure at each, force per area, or over nodes without areas force: linear between them and beyond them. Contacts whose
    // pressure is not positive are open. NULL and 0 for the penalty's law; an array whose count is 0 is DC_BAD_SIZE. There are no
    // multipliers then, and the penalty only estimates where contacts that close have touched: about the stiffness of the table in contact.
    // They are open from the gap on at which the last falling line has no pressure any more.
    const double *normal_pressures;
    // Number of gaps, and of pressures.
    size_t normal_count;
    // How long the increment lasts, positive; for coefficients that depend on the slip rate.
    double duration;
    // DC_DECAYING: the coefficient of fast sliding; `friction` is that of rest.
    double friction_in_motion;
    // DC_DECAYING: how fast it decays, time per length.
    double friction_decay;
    // DC_TABULATED: ascending pressures, one or more, ...
    const double *friction_pressures;
    // ... and their number; ...
    size_t friction_pressure_count;
    // ... ascending slip rates, one or more, length per time, ...
    const double *friction_rates;
    // ... and their number; ...
    size_t friction_rate_count;
    // ... and coefficients, for each rate at the first pressure, then for each at the next one: bilinear between them, constant beyond.
    // `friction` is 0 then.
    const double *friction_table;
    // A normal law of the caller's own, in the place of a table; NULL for none. What is said of the penalty beside a table holds.
    dc_normal_law normal_law;
    // DC_FUNCTION: the coefficient. `friction` is 0 then.
    dc_friction_law friction_law;
    // Handed to both.
    void *context;
} dc_law;

// What the cutting of the faces gave.
typedef struct dc_faces_report {
    // sizeof(dc_faces_report), set by the caller.
    size_t size;
    // Integration points.
    int32_t points;
    // Of these: paired with masters.
    int32_t paired;
    // Faces with points.
    int32_t faces;
    // Middles of edges and faces where the slave's own nodes carry no smooth surface: its faces are flat there.
    int32_t straight;
    // Whether nodes couple that did not since the last dc_faces_refresh, so that a sparsity pattern of before is too small: 0 or 1.
    int32_t grown;
    // 0.
    int32_t reserved;
} dc_faces_report;

// What stays fixed for one slave until it is paired anew.
typedef struct dc_pairing {
    // sizeof(dc_pairing), set by the caller.
    size_t size;
    // Number n of masters.
    int32_t master_count;
    // dc_basis.
    int32_t basis;
    // dc_fallback.
    int32_t fallback;
    // Whether the slave lies within the masters or on their border; 0 beyond it, where the fit extrapolates.
    int32_t encloses_slave;
    // Length.
    double support_radius;
    // Normal of the masters' average plane, outward: the direction to give next time, when they have turned.
    double normal[3];
} dc_pairing;

// What one element is besides its nodes. A field that is 0 has the value named first.
typedef struct dc_element {
    // sizeof(dc_element), set by the caller.
    size_t size;
    // dc_basis; 0 is DC_QUADRATIC.
    int32_t basis;
    // dc_weight: DC_CUBIC, ...
    int32_t weight;
    // dc_frame: DC_CO_MOVING, ...
    int32_t frame;
    // 0.
    int32_t reserved;
    // Radius of the domain of influence around the slave, length.
    double support_radius;
    // A direction to the outward side of the master. DC_GIVEN: looked at only if it is not zero.
    double outward[3];
    // DC_GIVEN only: the directions of the frame, orthonormal, `normal` outward.
    double t1[3];
    double t2[3];
    double normal[3];
} dc_element;

// Where an element touches.
typedef struct dc_point {
    // dc_outcome; only for DC_CONTACT are the numbers valid, else they are 0.
    int32_t outcome;
    // 0.
    int32_t reserved;
    // Signed gap, length: positive apart, negative penetrating.
    double gap;
    // Foot on the surface.
    double foot[3];
    // Unit normal there, outward.
    double normal[3];
} dc_point;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

// The name of a status, such as "bad-handle"; "unknown" for a number that is none. A constant text.
const char *dc_status_name(int32_t status);

// The sentence to the last status of this thread that was not DC_OK, with the numbers that led to it; it opens with a
// stable code, such as "repeated-node: ". Never NULL; empty before the first. It holds until the thread's next call.
const char *dc_message(void);

// The stable code of an outcome, such as "foot-outside", the same in all languages; "unknown" for a number that is
// none. A constant text.
const char *dc_outcome_code(int32_t outcome);

// The version of the library, such as "0.1.0". A constant text.
const char *dc_version(void);

// Chooses the vector instructions for the whole process: "scalar", "avx2", "avx512" or "neon". To be called before
// the first evaluation; without it the widest are used that the machine has, or those that the environment variable
// DIFFUSE_CONTACT_ISA names. Results with different instructions differ by rounding.
//
// DC_BAD_OPTION if the machine does not have them, or others have been in use before.
//
// # Safety
// `name` is NULL or a text that ends with a zero byte.
enum dc_status dc_set_isa(const char *name);

// The vector instructions in use, such as "avx2". A constant text.
const char *dc_isa(void);

// Sets how many threads evaluate, for the whole process: 1 to 1024, or 0 for the environment variable RAYON_NUM_THREADS, or else one per
// core. No result depends on it. Where ranks of MPI are the parallelism, 1. DC_BAD_OPTION for any other number, which changes nothing.
enum dc_status dc_set_threads(int32_t count);

// How many threads evaluate: 1 where none could be started.
size_t dc_thread_count(void);

// Fills the options with their defaults; options.size has to be set before.
//
// # Safety
// `options` is NULL, or as many bytes as its field `size` says may be written there.
enum dc_status dc_options_default(struct dc_options *options);

// Makes an interface and writes its handle. Everything is copied.
//
// `positions`: x, y, z of all `node_count` nodes; indices count from 0. `facets`: the master surface, 4 nodes for each
// facet, counter-clockwise seen from outside; the fourth is -1 for a triangle. `slaves`: the slave nodes, none of them on
// the master. `slave_facets`: as `facets`, for `areas` of `options`, and DC_BAD_OPTION where these are 0; NULL and 0 without. `options`: NULL
// for the defaults, which have no areas.
//
// There is no pairing yet: call dc_refresh. On failure the handle is NULL.
//
// # Safety
// The arrays have the given lengths, `options` as many bytes as its field `size` says.
enum dc_status dc_create(const double *positions,
                         size_t node_count,
                         const int32_t *facets,
                         size_t facet_count,
                         const int32_t *slaves,
                         size_t slave_count,
                         const int32_t *slave_facets,
                         size_t slave_facet_count,
                         const struct dc_options *options,
                         struct dc_interface **interface);

// Makes an interface of a surface in contact with itself: each of its nodes is a slave, and `facets` are all that it may touch. The surface
// may be the skins of several bodies. Slaves are in ascending order. Both sides push: give the
// law half of the penalty between two surfaces, of the tangential stiffness, of the shear limit and of normal pressures, and coefficients
// at half of the pressure.
// With `areas` of `options` they are those of `facets`; there are none by default, other than in Python. All else is as with dc_create;
// dc_window_create is DC_BAD_OPTION.
//
// # Safety
// As dc_create.
enum dc_status dc_create_self_contact(const double *positions,
                                      size_t node_count,
                                      const int32_t *facets,
                                      size_t facet_count,
                                      const struct dc_options *options,
                                      struct dc_interface **interface);

// Destroys an interface. NULL is DC_OK, a handle that was destroyed before is DC_BAD_HANDLE.
enum dc_status dc_destroy(struct dc_interface *interface);

// Numbers of nodes and of slaves. Either may be NULL.
//
// # Safety
// Each is NULL or may be written.
enum dc_status dc_counts(struct dc_interface *interface, size_t *node_count, size_t *slave_count);

// The slave nodes, in the order of results and multipliers: that of dc_create, ascending for a surface in contact with itself.
//
// # Safety
// `slaves` has `slave_count` entries.
enum dc_status dc_slaves(struct dc_interface *interface,
                         int32_t *slaves,
                         size_t slave_count);

// Makes these planes of symmetry, `plane_count` of them with 6 numbers each: x, y, z of a point of the plane, then of its unit normal
// to the side of the model. The master surface goes on beyond them as its mirror image, so that masters near a plane have
// neighbours on both sides, and where it ends in a plane is no border. Default: none; NULL and 0 take all away.
//
// Call it before the first dc_refresh: no slave is paired afterwards. The history of friction ends, unless the planes are the same: call
// dc_set_history after it. Planes lie still. They need DC_DOMAINS or DC_NODE_TO_FACET, else
// DC_BAD_OPTION. DC_BAD_SURFACE for a normal that is no unit vector, and for planes that are neither
// parallel nor at 180 degrees over a whole number.
//
// # Safety
// `planes` has 6 `plane_count` entries.
enum dc_status dc_set_symmetry(struct dc_interface *interface,
                               const double *planes,
                               size_t plane_count);

// Takes over the positions of the next evaluation, x, y, z of all nodes. The pairing stays. Call dc_follow in every iteration: with
// DC_DOMAINS a slave that slides by more than half the skin of its list, see dc_refresh, may lack nodes after a mere dc_update.
//
// # Safety
// `positions` has 3 `node_count` entries.
enum dc_status dc_update(struct dc_interface *interface,
                         const double *positions,
                         size_t node_count);

// As dc_update, but with DC_DOMAINS the lists of nodes follow: where something has moved too far for them, see dc_refresh, they are made
// anew. A slave stays with its side of the surface. `rebuilt`, which may be NULL, gets whether they are others now, 0 or 1: patterns of
// before are no longer theirs then. Contacts that are lost with the old lists are in the report of the next dc_refresh, contacts_lost and
// lost_gap.
//
// DC_FROZEN while the interface is frozen: it did what dc_update does.
//
// # Safety
// `positions` has 3 `node_count` entries; `rebuilt` is NULL or may be written.
enum dc_status dc_follow(struct dc_interface *interface,
                         const double *positions,
                         size_t node_count,
                         int32_t *rebuilt);

// Takes over the positions and pairs every slave. Call it once an increment. `report` may be NULL; its field `size` has to be set.
//
// With DC_DOMAINS the list of a slave stays while slave and masters together have moved by less than half its skin, 0.06 of the
// shortest half axis of its domains, and not so far that another sheet may be the closest one. Another list changes no gap, unless the
// slave comes to where the old one does not reach, such as another sheet: jump_node, lost_node and gained_node tell of that. Domains lie
// in the configuration of dc_create and are never renewed: they turn and stretch with the master. The first refresh of an increment is
// followed by dc_follow in its iterations.
//
// DC_FROZEN while the interface is frozen: it did what dc_update does, and the report is empty.
//
// # Safety
// `positions` has 3 `node_count` entries; `report` is NULL or has as many bytes as its field `size` says.
enum dc_status dc_refresh(struct dc_interface *interface,
                          const double *positions,
                          size_t node_count,
                          struct dc_report *report);

// As dc_refresh, but all lists of DC_DOMAINS are made anew, so that they follow from the positions alone: after a restart patterns, and with
// them the bits of a direct solver, are those of a run that makes them anew there, too.
//
// # Safety
// As dc_refresh.
enum dc_status dc_renew(struct dc_interface *interface,
                        const double *positions,
                        size_t node_count,
                        struct dc_report *report);

// Holds the pairing, for instance over the iterations of an increment: dc_refresh and dc_follow do what dc_update does, and return
// DC_FROZEN.
enum dc_status dc_freeze(struct dc_interface *interface);

// Ends what dc_freeze began.
enum dc_status dc_thaw(struct dc_interface *interface);

// Evaluates all slaves at the positions of the last dc_update, dc_follow or dc_refresh, in parallel. `mode` is a dc_mode: DC_GRADIENT
// for forces and tangent, DC_HESSIAN to keep every M, which dc_derivatives and the exact dc_triplets need. The result does not depend on
// the number of threads, bit for bit.
//
// DC_NOT_EVALUATED before the first dc_refresh. DC_TOO_LARGE if there is no memory for the results: there are none then, and the pairing stays.
enum dc_status dc_evaluate(struct dc_interface *interface,
                           int32_t mode);

// Which equations the displacements of the nodes have: 3 entries for each node, numbers below `equation_count`, none twice, -1
// for a displacement that is prescribed. NULL with both counts 0 for 3 node + axis, as it is at the beginning; NULL with any other count
// is an array that is missing, DC_BAD_POINTER. Patterns made before belong to the equations of before.
//
// # Safety
// `equations` is NULL or has 3 `node_count` entries.
enum dc_status dc_set_equations(struct dc_interface *interface,
                                const int32_t *equations,
                                size_t node_count,
                                size_t equation_count);

// The contact of the `slave`-th slave, counted from 0. Where it has none, DC_NO_CONTACT, and dc_message() says why.
//
// # Safety
// `contact` may be written.
enum dc_status dc_contact_of(struct dc_interface *interface, size_t slave, struct dc_contact *contact);

// Nodes and derivatives of the `slave`-th slave: `nodes`, slave first, n + 1 numbers; `gradient` N, 3(n+1) numbers, x, y, z
// of each node in that order; `hessian` M, the lower triangle row by row, entry (i, j <= i) at i(i+1)/2 + j, 3(n+1)(3n+4)/2 numbers.
// What is not wanted is NULL. The sizes are those of the arrays. DC_NO_CONTACT where there is none; the nodes are
// there even so, if it is paired. DC_NOT_EVALUATED for derivatives that the mode of dc_evaluate did not ask for.
//
// # Safety
// The arrays have the given lengths.
enum dc_status dc_derivatives(struct dc_interface *interface,
                              size_t slave,
                              int32_t *nodes,
                              size_t node_size,
                              double *gradient,
                              size_t gradient_size,
                              double *hessian,
                              size_t hessian_size);

// Outcomes and gaps of all slaves, one entry each; the gap is 0 without contact. Either may be NULL.
//
// # Safety
// The arrays have `slave_count` entries.
enum dc_status dc_gaps(struct dc_interface *interface, int32_t *outcomes, double *gaps, size_t slave_count);

// What a post-processor shows, for all slaves: `penetrations` max(0, -g), length; `forces` f = max(0, lambda - e g);
// `pressures` f over the area, a force where the interface has no areas. 0 without contact. Each may be NULL. With
// lambda <- f it is also the update of the augmented Lagrangian: `forces` may be the array of the multipliers.
//
// # Safety
// The arrays have `slave_count` entries, `law` as in dc_add_forces.
enum dc_status dc_forces(struct dc_interface *interface,
                         const struct dc_law *law,
                         double *penetrations,
                         double *forces,
                         double *pressures,
                         size_t slave_count);

// A factor for the increment, from 0.1 to 1, like PNEWDT: below 1 the increment had better be cut back by it. The smallest of
//
// - cutback_penetration R/(-g), for a slave that penetrates deeper than cutback_penetration x R, the support radius;
// - 0.5, for a slave that penetrated and whose foot lies outside its domain of influence in the last evaluation;
// - 0.25, for one whose element failed otherwise: no foot, singular fit, overflow.
//
// A slave penetrated if its gap was negative when it last had one since dc_refresh, or there; that it is not paired, too far, without a
// candidate or a facet over it, or beyond the border ends it. Contacts that a refresh loses are in dc_report (contacts_lost, lost_gap).
//
// # Safety
// `factor` may be written.
enum dc_status dc_cutback(struct dc_interface *interface,
                          double *factor);

// The feet x^d of all slaves and their derivatives, one slave after another, at the positions of the last dc_update, dc_follow or
// dc_refresh, for laws of the host's own. No evaluation of these positions is needed. With n the master_count of dc_contact_of, and the
// nodes of dc_derivatives, both of any dc_evaluate since the lists of nodes were made:
//
// - `weights` phi, n numbers for each slave, their sum is 1: a field over the nodes is sum phi_k u_k at the foot, x^d = sum phi_k x_k.
//   Behind planes of symmetry the images of a node add to its number, and their positions to the foot;
// - `foot` dx^d/dx, 3 rows of 3(n+1) numbers for each slave, ordered as the gradient of dc_derivatives, dimensionless;
// - `normal` dnu/dx, the same, 1/length.
//
// Without contact numbers are 0, and `outcomes`, a dc_outcome for each slave, says why; without a pairing n is 0. What is not
// wanted is NULL. The sizes are those of the arrays. DC_BAD_SIZE names the number that is needed.
//
// # Safety
// The arrays have the given lengths.
enum dc_status dc_feet(struct dc_interface *interface,
                       int32_t *outcomes,
                       size_t slave_count,
                       double *weights,
                       size_t weight_size,
                       double *foot,
                       size_t foot_size,
                       double *normal,
                       size_t normal_size);

// The dc_tangent for the next linear solution of a Newton iteration, to be put into a law before the tangent is assembled:
// DC_GAUSS_NEWTON far from equilibrium, where the exact tangent leads nowhere, DC_EXACT elsewhere.
//
// `residual` is the norm of the residual over the free equations, contact included; `force` the largest of the norms of external
// forces, contact forces and reactions at the same positions. Exact if residual / force <= 0.3 or the residual is 0, else
// DC_GAUSS_NEWTON, as for NaN.
int32_t dc_adaptive_tangent(double residual,
                            double force);

// A round of Uzawa's iteration for friction: the traction of each slave that carries force becomes its multiplier, so that the next
// equilibrium slips less where it sticks. Call it in an equilibrium whose dc_slip_errors are too large, with the law that it was solved
// with, whose `augmented` is 1; then dc_evaluate again. The rounds are part of the increment on its way: dc_accept takes them over,
// dc_roll_back forgets them.
//
// `moves`: 1 for each slave that takes part, 0 for others, where other bodies hold them and no multiplier can help; NULL for all.
//
// Without friction in the law nothing happens. DC_BAD_OPTION for friction without `augmented`, and as of dc_accept.
//
// # Safety
// `law` as in dc_add_forces; `moves` is NULL or has `slave_count` entries.
enum dc_status dc_augment(struct dc_interface *interface,
                          const struct dc_law *law,
                          const int32_t *moves,
                          size_t slave_count);

// How far each slave is from Coulomb's law without tangential stiffness, length: its slip since it stuck where it sticks, and what of it is
// not along the traction where it slides; 0 without force, history or friction. At the positions of the last dc_update, dc_follow or dc_refresh.
//
// # Safety
// `law` as in dc_augment; `errors` has `slave_count` entries.
enum dc_status dc_slip_errors(struct dc_interface *interface,
                              const struct dc_law *law,
                              double *errors,
                              size_t slave_count);

// Forgets what dc_augment did since the last dc_accept, and ends the evaluation. If that is anything no slave is paired until the next
// dc_refresh.
enum dc_status dc_roll_back(struct dc_interface *interface);

// Accepts the positions of the last dc_update, dc_follow or dc_refresh as the end of an increment: friction of the next one is measured
// from there. Call it once before the first increment, after dc_refresh, and then after each that has converged, with the multipliers it
// was solved with. Until then nothing of the history changes, so that an increment may be tried again.
// It ends the evaluation: call dc_evaluate again.
//
// If the law has no friction all slaves slide freely: where there is a history it goes on from their feet, and all counts are 0. Without a
// history nothing happens then. A slave whose outcome is DC_BEYOND_WINDOW keeps its history.
//
// `stuck_count` and `sliding_count` get the numbers of slaves that stick and that slide, `unanchored_count` that of slaves that carry
// force without friction, as they had no gap at the end of the increment before; `dropped_count` that of slaves that were closed then
// and have lost their contact element; `dissipated` the work of friction in the increment, energy. Each may be NULL.
//
// DC_BAD_OPTION for a law with friction if there can be none: for DC_DIFFUSE without DC_DOMAINS, or in a library built without its
// feature `friction`. DC_NODE_TO_FACET has friction in every build.
//
// # Safety
// `law` as in dc_add_forces; the others are NULL or may be written.
enum dc_status dc_accept(struct dc_interface *interface,
                         const struct dc_law *law,
                         size_t *stuck_count,
                         size_t *sliding_count,
                         size_t *unanchored_count,
                         size_t *dropped_count,
                         double *dissipated);

// Friction of all slaves at the positions of the last dc_evaluate, in DC_GRADIENT or DC_HESSIAN, one entry each: `states`
// dc_friction_state; `tractions` on the slave, 3 numbers each, force per area, a force where the interface has no areas; `slips` from
// the anchor, or of a slave that was open from its place of touch, length: the elastic slip, and where it slides what it has slid in the
// increment besides. With `augmented` they are from where it stuck, without its multiplier. 0 where a slave is DC_OPEN, as all are if the law has no friction. Each may be
// NULL. Call it before dc_accept, which ends the evaluation, with the law of the forces.
//
// DC_NOT_EVALUATED for slaves that carry force before the first dc_accept.
//
// # Safety
// `law` as in dc_add_forces; the arrays have `slave_count` entries, `tractions` three times as many.
enum dc_status dc_friction(struct dc_interface *interface,
                           const struct dc_law *law,
                           int32_t *states,
                           double *tractions,
                           double *slips,
                           size_t slave_count);

// The history of friction as plain numbers, for a restart: `count` gets how many there are, 0 without a history. `history` is NULL to
// learn that, or has room for `capacity` numbers: DC_BAD_SIZE if that is too little, and `count` is written all the same.
//
// # Safety
// `history` is NULL or has `capacity` entries; `count` may be written.
enum dc_status dc_history(struct dc_interface *interface,
                          double *history,
                          size_t capacity,
                          size_t *count);

// As dc_history, of what friction is measured from at the moment: with the rounds of dc_augment since the last accepted step. Another
// interface, such as one in a window made anew, goes on from it within the step.
//
// # Safety
// `history` is NULL or has `capacity` entries; `count` may be written.
enum dc_status dc_augmented_history(struct dc_interface *interface,
                                    double *history,
                                    size_t capacity,
                                    size_t *count);

// Goes on from numbers that dc_history gave, bit for bit; NULL and 0 for none. If they are others than the present ones no slave is paired
// until the next dc_refresh; one of a frozen interface does not pair.
//
// # Safety
// `history` has `count` entries.
enum dc_status dc_set_history(struct dc_interface *interface,
                              const double *history,
                              size_t count);

// Adds the contact forces R on the nodes to `forces`, one entry per equation. R is the force: it stands on the side of the
// external loads; the internal force of contact is -R. `active_count`, the number of slaves that carry force, may be NULL.
//
// DC_OVERFLOW if a sum is not finite: the forces then hold anything, and have to be made anew. With any other failure it is as it
// was.
//
// # Safety
// `forces` has `equation_count` entries; `law` is a dc_law with its `size` set, its multipliers have their number.
enum dc_status dc_add_forces(struct dc_interface *interface,
                             const struct dc_law *law,
                             double *forces,
                             size_t equation_count,
                             size_t *active_count);

// The tangent K = -dR/dx as triplets, counted from 0, in the order of the slaves; entries of the same place are to be summed.
// `triangle` is a dc_triangle. Writes their number to `count`. If the arrays are shorter, or NULL, that is all it does: call it with
// `capacity` 0 first, or with room for the sum of 9 (n + 1)^2 over all slaves.
//
// DC_BAD_SIZE if there is not room for all, and `capacity` is not 0; `count` is there even so.
//
// # Safety
// The arrays have `capacity` entries each; `law` as in dc_add_forces; `count` may be written.
enum dc_status dc_triplets(struct dc_interface *interface,
                           const struct dc_law *law,
                           int32_t triangle,
                           int32_t *rows,
                           int32_t *columns,
                           double *values,
                           size_t capacity,
                           size_t *count);

// Makes the union pattern of the pairing: an entry wherever any slave can have one, whether it carries force or not. So it
// stays valid until a dc_refresh (dc_report: changed, gained or lost is not 0) or a dc_follow (its last argument) changes the lists of nodes, or dc_set_equations the equations, and
// a solver can keep its symbolic factorisation as long. Both triangles are there; columns ascend in a row. It needs an evaluation, in any mode.
//
// Writes the handle and the number of entries, which may be NULL. On failure the handle is NULL.
//
// # Safety
// `pattern` may be written, `entry_count` is NULL or may be written.
enum dc_status dc_pattern_create(struct dc_interface *interface,
                                 struct dc_pattern **pattern,
                                 size_t *entry_count);

// Destroys a pattern. NULL is DC_OK. The interface may be gone already.
enum dc_status dc_pattern_destroy(struct dc_pattern *pattern);

// Copies out where the entries are, counted from 0: those of row i are `row_offsets[i]` to `row_offsets[i + 1]` - 1, in
// `columns`. There are equation_count + 1 offsets and entry_count columns. Either may be NULL.
//
// # Safety
// The arrays have the given lengths.
enum dc_status dc_pattern_structure(struct dc_pattern *pattern,
                                    int32_t *row_offsets,
                                    size_t row_offset_count,
                                    int32_t *columns,
                                    size_t column_count);

// Writes the tangent K = -dR/dx into `values`, one number for each entry of the pattern, zeros where nothing touches. In
// parallel; the result does not depend on the number of threads. `active_count` may be NULL.
//
// After dc_evaluate with DC_GRADIENT M of the slaves that carry force is evaluated some hundred at a time, added and forgotten: the values are
// those after DC_HESSIAN, bit for bit, and the memory for all M is saved.
//
// DC_PATTERN_MISMATCH if the pairing or the equations are not those of the pattern. DC_OVERFLOW if a sum is not finite. After
// a failure the values hold anything.
//
// # Safety
// `values` has `entry_count` entries; `law` as in dc_add_forces; `active_count` is NULL or may be written.
enum dc_status dc_pattern_fill(struct dc_pattern *pattern,
                               struct dc_interface *interface,
                               const struct dc_law *law,
                               double *values,
                               size_t entry_count,
                               size_t *active_count);

// Finds the places of the tangent's entries in a matrix in compressed sparse rows of the caller's, which has one row and column for each
// equation. Entries of row i are `row_offsets[i]` to `row_offsets[i + 1]` - 1, counted from 0; columns ascend in a row. It may have any
// entries besides those of dc_pattern_create, all of which have to be there: else DC_BAD_OPTION, and the message names row and column. The
// arrays are not kept. It stays valid as long as a pattern would. It needs an evaluation, in any mode.
//
// On failure the handle is NULL.
//
// # Safety
// There are `row_offset_count` offsets, equation_count + 1 of them, and `entry_count` columns; `map` may be written.
enum dc_status dc_map_create(struct dc_interface *interface,
                             const int32_t *row_offsets,
                             size_t row_offset_count,
                             const int32_t *columns,
                             size_t entry_count,
                             struct dc_map **map);

// As dc_map_create, of a matrix with 64-bit indices.
//
// # Safety
// As dc_map_create.
enum dc_status dc_map_create_64(struct dc_interface *interface,
                                const int64_t *row_offsets,
                                size_t row_offset_count,
                                const int64_t *columns,
                                size_t entry_count,
                                struct dc_map **map);

// Destroys a map. NULL is DC_OK. The interface may be gone already.
enum dc_status dc_map_destroy(struct dc_map *map);

// Adds the tangent K = -dR/dx to the `values` of a matrix of that structure, in parallel, as dc_pattern_fill does.
//
// DC_PATTERN_MISMATCH if the pairing or the equations are not those of the map. DC_OVERFLOW if a sum is not finite: the values then hold
// anything. With any other failure, but one of memory, they are as they were.
//
// # Safety
// `values` has `entry_count` entries; `law` as in dc_add_forces; `active_count` is NULL or may be written.
enum dc_status dc_map_add(struct dc_map *map,
                          struct dc_interface *interface,
                          const struct dc_law *law,
                          double *values,
                          size_t entry_count,
                          size_t *active_count);

// Makes the tangent K = -dR/dx at the positions of the last dc_update, dc_follow or dc_refresh, over the equations of the moment. It needs
// no evaluation, but a dc_refresh: what carries force is evaluated for it. It stays what it is when the interface moves on, or is destroyed. With friction
// K is not symmetric in general; without anchors it is DC_NOT_EVALUATED then.
//
// Writes the handle and the number of slaves that carry force, which may be NULL. On failure the handle is NULL.
//
// # Safety
// `law` as in dc_add_forces; `tangent` may be written, `active_count` is NULL or may be written.
enum dc_status dc_operator_create(struct dc_interface *interface,
                                  const struct dc_law *law,
                                  struct dc_operator **tangent,
                                  size_t *active_count);

// Destroys an operator. NULL is DC_OK. The interface may be gone already.
enum dc_status dc_operator_destroy(struct dc_operator *tangent);

// Adds K v to `product`, one entry per equation, in parallel. It differs from the product of the assembled matrix by rounding, and does not
// depend on the number of threads, bit for bit.
//
// DC_OVERFLOW if a sum is not finite: the product then holds anything. With any other failure it is as it was.
//
// # Safety
// The arrays have `equation_count` entries each.
enum dc_status dc_operator_product(struct dc_operator *tangent,
                                   const double *v,
                                   double *product,
                                   size_t equation_count);

// Adds K^T v to `product`, as dc_operator_product adds K v: for methods that need both where friction makes K unsymmetric.
//
// # Safety
// The arrays have `equation_count` entries each.
enum dc_status dc_operator_transposed_product(struct dc_operator *tangent,
                                              const double *v,
                                              double *product,
                                              size_t equation_count);

// Adds the diagonal of K to `diagonal`, one entry per equation; failures as of dc_operator_product.
//
// # Safety
// `diagonal` has `equation_count` entries.
enum dc_status dc_operator_diagonal(struct dc_operator *tangent, double *diagonal, size_t equation_count);

// Cuts a window out of the master surface of an interface, at the positions of its last dc_update, dc_follow or dc_refresh: what slaves in
// `box_count` boxes can need of it, 6 numbers each: lowest and highest x, y, z. The window holds while no node of the master has moved by more than
// `skin`. It needs DC_DOMAINS, else DC_BAD_OPTION; so it is for boxes that are none and for an interface that has a window only.
//
// Boxes reach beyond the slaves by distance_limit, and by what slaves move until the next window. On failure the handle is NULL.
//
// # Safety
// `boxes` has 6 `box_count` entries, `window` may be written.
enum dc_status dc_window_create(struct dc_interface *interface,
                                const double *boxes,
                                size_t box_count,
                                double skin,
                                struct dc_window **window);

// Destroys a window. NULL is DC_OK. Interfaces made of it stay.
enum dc_status dc_window_destroy(struct dc_window *window);

// Numbers of nodes and facets of a window, and of the integers and floating-point numbers of dc_window_numbers. Each may be NULL.
//
// # Safety
// Each is NULL or may be written.
enum dc_status dc_window_counts(struct dc_window *window,
                                size_t *node_count,
                                size_t *facet_count,
                                size_t *integer_count,
                                size_t *real_count);

// Numbers of its nodes and of its facets in the whole surface, ascending. Either may be NULL.
//
// # Safety
// The arrays have the given lengths.
enum dc_status dc_window_names(struct dc_window *window,
                               int64_t *nodes,
                               size_t node_count,
                               int64_t *facets,
                               size_t facet_count);

// The window as plain numbers, to be sent: dc_window_from_numbers makes the same one of them. dc_window_counts tells how many they are.
//
// # Safety
// The arrays have the given lengths.
enum dc_status dc_window_numbers(struct dc_window *window,
                                 int64_t *integers,
                                 size_t integer_count,
                                 double *reals,
                                 size_t real_count);

// Makes a window of the numbers of dc_window_numbers; DC_BAD_OPTION for others. On failure the handle is NULL.
//
// # Safety
// The arrays have the given lengths, `window` may be written.
enum dc_status dc_window_from_numbers(const int64_t *integers,
                                      size_t integer_count,
                                      const double *reals,
                                      size_t real_count,
                                      struct dc_window **window);

// Makes an interface of slaves that know a window of the master only. As dc_create, but the first nodes are those of the window, in the order
// of dc_window_names, where they were when it was made; slaves come after them. Planes of symmetry come with the window. Weight, basis and
// feature angle have to be those that it was made with, else DC_BAD_OPTION.
//
// With `areas` of `options` slaves and all other nodes of `slave_facets` have to be in their first positions here, also in a later
// increment: areas are those at these positions. `slave_facets` are all facets at the slaves, in the order of the whole.
//
// Results are those of an interface with the whole surface, bit for bit, or the outcome DC_BEYOND_WINDOW. dc_set_symmetry is refused.
//
// # Safety
// As dc_create.
enum dc_status dc_create_in_window(struct dc_window *window,
                                   const double *positions,
                                   size_t node_count,
                                   const int32_t *slaves,
                                   size_t slave_count,
                                   const int32_t *slave_facets,
                                   size_t slave_facet_count,
                                   const struct dc_options *options,
                                   struct dc_interface **interface);

// Lowest x, y, z, highest x, y, z of facets, then the longest edge of one, 7 numbers. Those of the whole surface, for dc_part_create,
// are the least of the first three of all ranks, and the greatest of the others. Without facets they are infinite, and 0. Facets are
// checked as in dc_create, each by itself.
//
// # Safety
// `positions` has 3 `node_count` entries, `facets` 4 `facet_count`; `extents` has room for 7.
enum dc_status dc_extents(const double *positions,
                          size_t node_count,
                          const int32_t *facets,
                          size_t facet_count,
                          double *extents);

// Boxes around groups of points, for windows: at most `most`, 6 numbers each as in dc_window_create, reaching `reach` beyond each point,
// finite and at least 0. `box_count` gets how many there are. Points that are not finite belong to no box.
//
// # Safety
// `positions` has 3 `point_count` entries, `boxes` room for 6 `most`; `box_count` may be written.
enum dc_status dc_boxes_around(const double *positions,
                               size_t point_count,
                               double reach,
                               size_t most,
                               double *boxes,
                               size_t *box_count);

// Makes a part of a master surface where no rank holds the whole, in the first positions. `facets` are those that the rank owns and
// those around them, as in dc_create; each facet of the whole surface is owned by one rank. `node_names` and `facet_names` are their
// numbers in the whole surface. `owned` is 1 for the own facets and 0 for the others. `known`, lowest and highest x, y, z, is a box:
// every facet that meets it is here. `extents` are those of the whole surface, see dc_extents: finite, and around the own facets, else
// DC_BAD_OPTION with the message "invalid-extents", if there are facets. `planes` as in dc_set_symmetry. Of `options` weight, basis and
// feature angle count.
//
// Then ranks exchange dc_part_demands and call dc_part_settle, twice, and cut windows with dc_part_window. DC_BAD_OPTION with the
// message "part-too-narrow" asks for more facets around the own ones and a larger box. On failure the handle is NULL.
//
// # Safety
// The arrays have the given lengths, `known` has 6 entries, `extents` 7, `planes` 6 `plane_count`; `part` may be written.
enum dc_status dc_part_create(const double *positions,
                              const int64_t *node_names,
                              size_t node_count,
                              const int32_t *facets,
                              const int64_t *facet_names,
                              const int32_t *owned,
                              size_t facet_count,
                              const double *known,
                              const double *extents,
                              const double *planes,
                              size_t plane_count,
                              const struct dc_options *options,
                              struct dc_part **part);

// Destroys a part. NULL is DC_OK. Windows cut from it stay.
enum dc_status dc_part_destroy(struct dc_part *part);

// What other ranks have to know in this round, those whose known boxes meet that of this part, as plain numbers. The counts get how
// many there are; each may be NULL. So may both arrays be.
//
// # Safety
// Each array is NULL or has room for as many entries as said; each count is NULL or may be written.
enum dc_status dc_part_demands(struct dc_part *part,
                               int64_t *integers,
                               size_t integer_capacity,
                               size_t *integer_count,
                               double *reals,
                               size_t real_capacity,
                               size_t *real_count);

// Takes over what other ranks ask for: the numbers of dc_part_demands of all of them, one after another. `is_settled` gets 1 when
// windows can be cut, and 0 when there is another round; all ranks take the same number. DC_BAD_OPTION with the message
// "part-too-narrow" as in dc_part_create. Nothing has changed then.
//
// # Safety
// The arrays have the given lengths, `is_settled` may be written.
enum dc_status dc_part_settle(struct dc_part *part,
                              const int64_t *integers,
                              size_t integer_count,
                              const double *reals,
                              size_t real_count,
                              int32_t *is_settled);

// As dc_window_create, of the own facets. `positions` are those of the moment, of the nodes of dc_part_create in their order; only the
// corners of own facets are looked at. DC_BAD_OPTION before dc_part_settle has said that domains are settled.
//
// # Safety
// `positions` has 3 `node_count` entries, `boxes` 6 `box_count`; `window` may be written.
enum dc_status dc_part_window(struct dc_part *part,
                              const double *positions,
                              size_t node_count,
                              const double *boxes,
                              size_t box_count,
                              double skin,
                              struct dc_window **window);

// Makes one window of those of the same boxes from several ranks. DC_BAD_OPTION for those of different surfaces, options, boxes or
// skins, and for none. The windows stay. On failure the handle is NULL.
//
// # Safety
// `windows` has `window_count` entries, `joined` may be written.
enum dc_status dc_window_joined(struct dc_window *const *windows,
                                size_t window_count,
                                struct dc_window **joined);

// First positions of the nodes of a window, x, y, z each, in the order of dc_window_names.
//
// # Safety
// `positions` has 3 `node_count` entries.
enum dc_status dc_window_first_positions(struct dc_window *window, double *positions, size_t node_count);

// How many numbers of a history each slave has, so that histories go with slaves to another rank: one after another they are a history
// again. One of dc_faces_history has two parts for each slave. `part_count` gets the number of parts; `lengths` is NULL to ask for it.
//
// # Safety
// `history` has `count` entries; `lengths` is NULL or has `capacity`; `part_count` may be written.
enum dc_status dc_history_lengths(const double *history,
                                  size_t count,
                                  size_t *lengths,
                                  size_t capacity,
                                  size_t *part_count);

// Makes an object for contact over faces and writes its handle. Everything is copied.
//
// `positions`: x, y, z of all `node_count` nodes in the first configuration; indices count from 0. `facets`: the master surface,
// `slave_facets`: the faces of the slave, none of their nodes on the master; of both 4 nodes for each facet, counter-clockwise
// seen from outside, the fourth -1 for a triangle. NULL and 0 where there are no slave facets, as on a rank of MPI. `options`: NULL for the
// defaults; `rule` has to be DC_DOMAINS unless `element` is DC_NODE_TO_FACET, `areas` and `cutback_penetration` have no meaning. `degree`: 2 or 4, of the polynomials that are
// integrated exactly on each piece of a face.
//
// On failure the handle is NULL.
//
// # Safety
// The arrays have the given lengths, `options` as many bytes as its field `size` says.
enum dc_status dc_faces_create(const double *positions,
                               size_t node_count,
                               const int32_t *facets,
                               size_t facet_count,
                               const int32_t *slave_facets,
                               size_t slave_facet_count,
                               const struct dc_options *options,
                               int32_t degree,
                               struct dc_faces **faces);

// Makes an object for contact over faces of a surface with itself: each of its facets is a face of the slave, and `facets` are all that it
// may touch. The surface may be the skins of several bodies, and its nodes are the slaves. Give the law half of everything
// between two surfaces, as with dc_create_self_contact. All else is as with dc_faces_create.
//
// # Safety
// As dc_faces_create.
enum dc_status dc_faces_create_self_contact(const double *positions,
                                            size_t node_count,
                                            const int32_t *facets,
                                            size_t facet_count,
                                            const struct dc_options *options,
                                            int32_t degree,
                                            struct dc_faces **faces);

// Destroys it. NULL is DC_OK, a handle that was destroyed before is DC_BAD_HANDLE.
enum dc_status dc_faces_destroy(struct dc_faces *faces);

// Numbers of nodes and of slave nodes, those of the slave facets. Either may be NULL.
//
// # Safety
// Each is NULL or may be written.
enum dc_status dc_faces_counts(struct dc_faces *faces, size_t *node_count, size_t *slave_count);

// The slave nodes, ascending: the order of results and multipliers. A node on an edge of the slave sharper than the feature angle is
// there once for each sheet that meets there.
//
// # Safety
// `slaves` has `slave_count` entries.
enum dc_status dc_faces_slaves(struct dc_faces *faces,
                               int32_t *slaves,
                               size_t slave_count);

// As dc_set_symmetry, for both surfaces, in the first configuration. The history of friction ends, unless the planes are the same: call
// dc_faces_set_history after it. There is no contact until the next dc_faces_refresh.
//
// # Safety
// `planes` has 6 `plane_count` entries.
enum dc_status dc_faces_set_symmetry(struct dc_faces *faces,
                                     const double *planes,
                                     size_t plane_count);

// Where the pressure follows from the gap: `pressures` is a dc_face_pressures, DC_NODE_PRESSURES before the first call. Take
// DC_POINT_PRESSURES where faces are coarse beside the master's curvature: an average gap closes late there. Multipliers are
// interpolated between the nodes then. The next dc_faces_evaluate sees it.
enum dc_status dc_faces_set_pressures(struct dc_faces *faces,
                                      int32_t pressures);

// The flat facets between all nodes of faces of second order, as dc_faces_create takes them: 4 for each face with 6 nodes, 5 for one
// with 8, 4 for one with 9. `quadratic`: `nodes_per_face` nodes for each face, corners counter-clockwise seen from outside, then the middles
// of the edges from the first corner on, then the centre. `facets` has room for `facet_capacity` facets of 4 nodes.
//
// # Safety
// The arrays have the given lengths.
enum dc_status dc_flat_facets(const int32_t *quadratic,
                              size_t face_count,
                              size_t nodes_per_face,
                              int32_t *facets,
                              size_t facet_capacity);

// Makes faces of second order carry the forces on the facets that they are made of, on both sides: by all of their shape functions, so
// that a uniform pressure is in equilibrium with a uniform stress inside. `quadratic` as in dc_flat_facets. A call for each
// number of nodes adds to those before. The history of friction ends, and there is no contact until the next dc_faces_refresh.
//
// # Safety
// `quadratic` has `face_count` times `nodes_per_face` entries.
enum dc_status dc_faces_add_quadratic(struct dc_faces *faces,
                                      const int32_t *quadratic,
                                      size_t face_count,
                                      size_t nodes_per_face);

// As dc_set_equations.
//
// # Safety
// `equations` is NULL or has 3 `node_count` entries.
enum dc_status dc_faces_set_equations(struct dc_faces *faces,
                                      const int32_t *equations,
                                      size_t node_count,
                                      size_t equation_count);

// Takes over the positions and cuts the faces anew. Call it once an increment. `report` may be NULL; its field `size` has to be set.
//
// # Safety
// `positions` has 3 `node_count` entries; `report` is NULL or has as many bytes as its field `size` says.
enum dc_status dc_faces_refresh(struct dc_faces *faces,
                                const double *positions,
                                size_t node_count,
                                struct dc_faces_report *report);

// As dc_faces_refresh, in every iteration: near equilibrium faces stay cut as they are, and the pattern does not shrink.
//
// # Safety
// As dc_faces_refresh.
enum dc_status dc_faces_update(struct dc_faces *faces,
                               const double *positions,
                               size_t node_count,
                               struct dc_faces_report *report);

// Gaps, pressures and forces at the positions of the last dc_faces_update or dc_faces_refresh, in parallel. The penalty of `law` is per
// area, its multipliers are pressures, one for each slave node; its tangent is not looked at. `mode` is a dc_mode: DC_GRADIENT for forces
// and e F G^T, DC_HESSIAN for the exact tangent. DC_NOT_EVALUATED before the first dc_faces_refresh or dc_faces_update, and for a law
// with friction where nodes carry pressure before dc_faces_accept. The result does not depend on the number of threads, bit for bit.
// DC_TOO_LARGE if there is no memory for the results: there are none then. After any other refusal those of before stay.
//
// # Safety
// `law` is a dc_law with its `size` set, its multipliers have their number.
enum dc_status dc_faces_evaluate(struct dc_faces *faces,
                                 const struct dc_law *law,
                                 int32_t mode);

// Contact of all slave nodes, one entry each: `outcomes` dc_outcome; `gaps` the average gap, length; `pressures` max(0, lambda - e g),
// force per area, which are the multipliers of the next round of the augmented Lagrangian; `areas` over the master in the first
// configuration, length^2; `normals` the mean unit normal of the master, 3 numbers each. Where nothing lies over a node gap and normal
// are 0. Each may be NULL.
//
// # Safety
// The arrays have `slave_count` entries, `normals` three times as many.
enum dc_status dc_faces_contacts(struct dc_faces *faces,
                                 int32_t *outcomes,
                                 double *gaps,
                                 double *pressures,
                                 double *areas,
                                 double *normals,
                                 size_t slave_count);

// Friction of all slave nodes, of the last evaluation, one entry each: `states` dc_friction_state; `tractions` on the slave, force per area,
// 3 numbers each; `slips` as of dc_friction, length. Each may be NULL.
//
// # Safety
// The arrays have `slave_count` entries, `tractions` three times as many.
enum dc_status dc_faces_friction(struct dc_faces *faces,
                                 int32_t *states,
                                 double *tractions,
                                 double *slips,
                                 size_t slave_count);

// As dc_accept, of the positions of the last dc_faces_refresh or dc_faces_update: call it once before the first increment, after
// dc_faces_refresh, and then after each that has converged. `unanchored_count` gets the number of nodes that carry pressure without
// friction, as nothing lay over them at the end of the increment before, `dropped_count` that of nodes that carried pressure then and have
// nothing over them now. Every build of the library has it.
//
// # Safety
// `law` as in dc_faces_evaluate; the others are NULL or may be written.
enum dc_status dc_faces_accept(struct dc_faces *faces,
                               const struct dc_law *law,
                               size_t *stuck_count,
                               size_t *sliding_count,
                               size_t *unanchored_count,
                               size_t *dropped_count,
                               double *dissipated);

// As dc_augment, of the nodes of the slave's faces; then dc_faces_evaluate again.
//
// # Safety
// As dc_augment.
enum dc_status dc_faces_augment(struct dc_faces *faces,
                                const struct dc_law *law,
                                const int32_t *moves,
                                size_t slave_count);

// As dc_slip_errors, at the positions of the last dc_faces_update or dc_faces_refresh.
//
// # Safety
// As dc_slip_errors.
enum dc_status dc_faces_slip_errors(struct dc_faces *faces,
                                    const struct dc_law *law,
                                    double *errors,
                                    size_t slave_count);

// As dc_roll_back; if there was anything to forget there is no contact until the next dc_faces_refresh.
enum dc_status dc_faces_roll_back(struct dc_faces *faces);

// As dc_history.
//
// # Safety
// `history` is NULL or has `capacity` entries; `count` may be written.
enum dc_status dc_faces_history(struct dc_faces *faces, double *history, size_t capacity, size_t *count);

// As dc_augmented_history.
//
// # Safety
// `history` is NULL or has `capacity` entries; `count` may be written.
enum dc_status dc_faces_augmented_history(struct dc_faces *faces, double *history, size_t capacity, size_t *count);

// Goes on from numbers that dc_faces_history gave, bit for bit; NULL and 0 for none. If they are others than the present ones there is no
// contact until the next dc_faces_refresh.
//
// # Safety
// `history` has `count` entries.
enum dc_status dc_faces_set_history(struct dc_faces *faces,
                                    const double *history,
                                    size_t count);

// What contact is at the integration points that lie over the master, face by face, by the pressures of the last dc_faces_evaluate; found
// anew by each call. `faces_of_points` gets numbers of their faces among the slave's; `positions` places on the slave's own smooth surface,
// 3 numbers each, length; `areas` what each stands for of its face in the first configuration, length^2; `gaps` length; `normals` the unit
// normals of the master, 3 numbers each; `pressures` force per area, interpolated between the nodes or their own as dc_faces_set_pressures says; `tractions` friction on the slave, 3 numbers each, force per area.
//
// Each may be NULL. With all of them NULL `point_count` gets how many points there are. DC_BAD_SIZE where `capacity` is less.
// DC_NOT_EVALUATED at positions that have no evaluation.
//
// # Safety
// The arrays have room for `capacity` points; `point_count` is NULL or may be written.
enum dc_status dc_faces_points(struct dc_faces *faces,
                               int32_t *faces_of_points,
                               double *positions,
                               double *areas,
                               double *gaps,
                               double *normals,
                               double *pressures,
                               double *tractions,
                               size_t capacity,
                               size_t *point_count);

// Adds the contact forces R on the nodes to `forces`, one entry per equation, as dc_add_forces does. `active_count`, the number of
// slave nodes that carry pressure, and `missed_count` may be NULL. Of loaded faces, points are missed that carry no force although
// they should: those below their facet whose element has no result, those without a place on their own face or the facet, those whose line
// of force meets no place of the facet, and those whose derivatives overflow.
//
// DC_OVERFLOW if a sum is not finite: the forces then hold anything, and have to be made anew.
//
// # Safety
// `forces` has `equation_count` entries.
enum dc_status dc_faces_add_forces(struct dc_faces *faces,
                                   double *forces,
                                   size_t equation_count,
                                   size_t *active_count,
                                   size_t *missed_count);

// Adds K v to `product`, one entry per equation, without a matrix, with the K of dc_faces_triplets, of friction, too. It differs from the
// product of the assembled matrix by rounding, and does not depend on the number of threads, bit for bit.
//
// DC_OVERFLOW if a sum is not finite: the product then holds anything. With any other failure it is as it was.
//
// # Safety
// The arrays have `equation_count` entries each.
enum dc_status dc_faces_product(struct dc_faces *faces,
                                int32_t tangent,
                                const double *v,
                                double *product,
                                size_t equation_count);

// The tangent K = -dR/dx as triplets, counted from 0, all of it, for it is not symmetric; entries of the same place are to be summed.
// Entries that are exactly zero are left out, so that their number may change from one evaluation to the next.
// `tangent` is a dc_tangent: DC_GAUSS_NEWTON leaves out what the directions of the forces add. Writes their number to `count`. If the
// arrays are shorter, or NULL, that is all it does: call it with `capacity` 0 first.
//
// DC_BAD_SIZE if there is not room for all, and `capacity` is not 0; `count` is there even so.
//
// # Safety
// The arrays have `capacity` entries each; `count` may be written.
enum dc_status dc_faces_triplets(struct dc_faces *faces,
                                 int32_t tangent,
                                 int32_t *rows,
                                 int32_t *columns,
                                 double *values,
                                 size_t capacity,
                                 size_t *count);

// Which nodes couple with one another, for the pattern of a host's matrix: cliques, one for each slave node with points around it. The nodes
// of clique k are `nodes[offsets[k]]` to `nodes[offsets[k + 1] - 1]`, ascending. An entry of the tangent is in the rows and columns of two
// nodes of one clique, whatever evaluation follows. They hold all that has coupled since the last dc_faces_refresh: where
// dc_faces_update says `grown` they are more than before, and after a dc_faces_refresh other ones. They need no evaluation.
//
// `clique_count` gets their number, `entry_count` that of all their nodes; there is an offset more than cliques. Each may be NULL: call it
// without arrays first. DC_BAD_SIZE if there is not room for all. Before the first dc_faces_refresh there are none.
//
// # Safety
// `offsets` has `offset_capacity` entries, `nodes` has `node_capacity`, or they are NULL; the others are NULL or may be written.
enum dc_status dc_faces_cliques(struct dc_faces *faces,
                                int32_t *offsets,
                                size_t offset_capacity,
                                int32_t *nodes,
                                size_t node_capacity,
                                size_t *clique_count,
                                size_t *entry_count);

// Makes an object for contact over faces that knows a window of either surface only, two handles. Nodes are those of `master` in the
// order of dc_window_names, then those of `slave`; `positions` are where they were when the window of the master was made. The faces are
// those that meet the boxes of `slave`, which is made once, in the first positions, of an interface whose master surface are the faces
// of the slave. The boxes of `master` hold these faces and what is within the limit of the distance; it is made anew as for
// dc_create_in_window.
//
// Gaps, pressures and areas after a dc_faces_refresh are those of the whole surfaces, bit for bit, or the node has the outcome
// DC_BEYOND_WINDOW and no pressure. Rows of forces and tangent are those of the whole where all nodes of the faces at their node are
// known. The history of friction names nodes by their numbers in the whole surfaces, as dc_window_names: two points of each slave.
//
// DC_BAD_OPTION without a `distance_limit`, and for windows of other options or planes of symmetry. dc_faces_set_symmetry and
// dc_faces_add_quadratic are DC_BAD_OPTION, too, with the message "in-window"; dc_faces_add_quadratic_by_number is for windows.
// On failure the handle is NULL.
//
// # Safety
// `positions` has 3 `node_count` entries, `options` as many bytes as its field `size` says; `faces` may be written.
enum dc_status dc_faces_create_in_window(struct dc_window *master,
                                         struct dc_window *slave,
                                         const double *positions,
                                         size_t node_count,
                                         const struct dc_options *options,
                                         int32_t degree,
                                         struct dc_faces **faces);

// As dc_faces_add_quadratic, for windows too: nodes are numbers in the whole surface, as dc_window_names. `side`: 0 for faces of the
// master, 1 for faces of the slave. Hand over all faces that have a node in the window; more do no harm. Where forces would act on a node
// that the window does not have, the outcome is DC_BEYOND_WINDOW.
//
// # Safety
// `quadratic` has `face_count` times `nodes_per_face` entries.
enum dc_status dc_faces_add_quadratic_by_number(struct dc_faces *faces,
                                                int32_t side,
                                                const int64_t *quadratic,
                                                size_t face_count,
                                                size_t nodes_per_face);

// Which of the candidates take part in the fit around a slave: the neighbour search of the options, as an interface does
// it, but without facets, so without sharp edges, borders and domains of influence: DC_DOMAINS, the default rule, is DC_HULL_LAYERS
// here, with the same layers as if that had been asked for. `slave` has 3 numbers, `candidates` 3 each, `outward` is a
// direction to the outward side of the master. `masters` gets the numbers of those chosen, counted from 0, ascending; it has
// room for `capacity` of them.
//
// DC_NO_CONTACT if the candidates carry no fit; nothing is written then.
//
// # Safety
// The arrays have the given lengths; `options` is NULL or has as many bytes as its field `size` says, as has `pairing`.
enum dc_status dc_pair(const struct dc_options *options,
                       const double *slave,
                       const double *candidates,
                       size_t candidate_count,
                       const double *outward,
                       int32_t *masters,
                       size_t capacity,
                       struct dc_pairing *pairing);

// Gap, foot and normal of one element, and as far as `mode`, a dc_mode, asks for them N and M, in the order of dc_derivatives:
// slave, master 1, ..., master n. `slave` has 3 numbers, `masters` 3 n. The order of the nodes of a pairing does not matter, but for
// rounding.
//
// DC_NO_CONTACT if the element has no result: point->outcome and dc_message() say why. The derivatives then hold anything, as they do
// if the runtime refuses numbers of the element: DC_NOT_FINITE, DC_BAD_OPTION for a support radius or a frame, DC_BAD_SIZE for too few
// masters; the outcome is DC_REFUSED then. (Masters that have no average plane, as two never have, are DC_NO_CONTACT.)
//
// # Safety
// The arrays have the given lengths, `element` as many bytes as its field `size` says.
enum dc_status dc_gap(const struct dc_element *element,
                      const double *slave,
                      const double *masters,
                      size_t master_count,
                      int32_t mode,
                      struct dc_point *point,
                      double *gradient,
                      size_t gradient_size,
                      double *hessian,
                      size_t hessian_size);

// Force and stiffness of one element from its gap and derivatives, over its own 3(n+1) coordinates: R = f N into `nodal_forces`, K = -dR/dx
// into `tangent`, 3(n+1) square, both triangles. Zeros if it carries no force. `force` f. What is not wanted is NULL. `area` is the
// slave's tributary area, 1 where the penalty is one per node. `hessian` may be NULL for DC_GAUSS_NEWTON or without `tangent`.
//
// After a failure `nodal_forces` and `tangent` hold anything.
//
// # Safety
// `gradient` has 3(`master_count` + 1) entries, `hessian` those of its lower triangle, `nodal_forces` and `tangent` have the given
// lengths; `law` as in dc_add_forces, with one multiplier or none.
enum dc_status dc_element_system(const struct dc_law *law,
                                 double gap,
                                 double area,
                                 size_t master_count,
                                 const double *gradient,
                                 const double *hessian,
                                 double *force,
                                 double *nodal_forces,
                                 size_t nodal_forces_size,
                                 double *tangent,
                                 size_t tangent_size);

// dc_gap for `element_count` elements that share what `element` says, but for its outward direction: `outwards` has 3 numbers for
// each, or is NULL for element->outward. `slaves` has 3 numbers for each; the masters of element k are those from `offsets[k]` to
// `offsets[k + 1]` - 1 of `masters`; `offsets` ascends from 0 and has element_count + 1 entries. `support_radii` has one number for
// each, or is NULL for element->support_radius.
//
// One after another without gaps: `points`, one each; `gradients`, 3(n+1) numbers each; `hessians`, 3(n+1)(3n+4)/2 numbers each; their
// sizes are those of the arrays. What the mode does not ask for may be NULL. Elements without result are told by their outcome, with
// derivatives of 0; the status is that of the call. Results differ from those of dc_gap by rounding.
//
// Runs in the calling thread: several may call at once.
//
// # Safety
// The arrays have the given lengths, `element` as many bytes as its field `size` says.
enum dc_status dc_gap_batch(const struct dc_element *element,
                            size_t element_count,
                            const double *outwards,
                            const double *support_radii,
                            const double *slaves,
                            const double *masters,
                            const size_t *offsets,
                            int32_t mode,
                            struct dc_point *points,
                            double *gradients,
                            size_t gradient_size,
                            double *hessians,
                            size_t hessian_size);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* DIFFUSE_CONTACT_H */
