#include "stylet/scene/schema.hpp"

#include "stylet/scene/block.hpp"
#include "stylet/scene/quantities.hpp"
#include "stylet/scene/schema_needle.hpp"

#include <functional>

namespace stylet {

namespace {

// Mesh

Codec<Ellipse> ellipse() {
  return block<Ellipse>(
      {field("centre", &Ellipse::centre, point<ReferencePoint>("m"), "Centre.").required(),
       field("size", &Ellipse::width, &Ellipse::height, pair("m", positive),
             "Full width and height.")
           .required()});
}

Codec<std::vector<ReferencePoint>> polyline() {
  return list(point<ReferencePoint>("m"));
}

Codec<RectangleMesh> rectangle() {
  using R = RectangleMesh;
  const auto inner_region = block<InnerRegion>(
      {field("name", &InnerRegion::name, text("a name"), "Name of the region.").required(),
       alternative("ellipse", &InnerRegion::outline, ellipse(), "Outline as an ellipse."),
       alternative("polygon", &InnerRegion::outline, polyline(), "Outline by its corners.")},
      {{"ellipse", "polygon"}});
  const auto curve = block<InnerCurve>(
      {field("name", &InnerCurve::name, text("a name"), "Name of the curve.").required(),
       field("points", &InnerCurve::points, polyline(), "Its corners, along grid lines.")
           .required()});
  const Range below_overlap{.min = 0, .max = 0.3, .max_open = true};
  const Choices<Diagonals> diagonals = {{"one_way", Diagonals::one_way},
                                        {"alternating", Diagonals::alternating}};
  return block<R>(
      {field("origin", &R::origin, point<ReferencePoint>("m"), "Lower left corner."),
       field("size", &R::width, &R::height, pair("m", positive), "Width and height.").required(),
       field("columns", &R::columns, integer(1), "Squares across the width.").required(),
       field("rows", &R::rows, integer(1), "Squares across the height.").required(),
       field("diagonals", &R::diagonals, choice(diagonals), "How squares are cut into triangles."),
       field("jitter", &R::jitter, plain(below_overlap),
             "Random shift of inner nodes as a fraction of the spacing."),
       field("seed", &R::seed, integer(0), "Seed of the random shift."),
       field("region", &R::region, text("a name"), "Region outside the inner regions."),
       field("inner_regions", &R::inner_regions, list(inner_region),
             "Regions whose outline the triangles follow."),
       field("curves", &R::curves, list(curve),
             "Named lines besides left, right, bottom and top.")});
}

Codec<BoxMesh> box() {
  using B = BoxMesh;
  const auto ellipsoid =
      block<Ellipsoid>({field("centre", &Ellipsoid::centre, place("m"), "Centre.").required(),
                        field("size", &Ellipsoid::width, &Ellipsoid::height, &Ellipsoid::depth,
                              triple("m", positive), "Full extents.")
                            .required()});
  const auto inner_region = block<SolidRegion>(
      {field("name", &SolidRegion::name, text("a name"), "Name of the region.").required(),
       field("ellipsoid", &SolidRegion::ellipsoid, ellipsoid,
             "The tetrahedra whose centre is in it; the outline is stepped.")
           .required()});
  const Range below_overlap{.min = 0, .max = 0.3, .max_open = true};
  return block<B>({field("origin", &B::origin, place("m"), "Left, bottom, back corner."),
                   field("size", &B::width, &B::height, &B::depth, triple("m", positive),
                         "Width, height and depth.")
                       .required(),
                   field("columns", &B::columns, integer(1), "Bricks across the width.").required(),
                   field("rows", &B::rows, integer(1), "Bricks across the height.").required(),
                   field("layers", &B::layers, integer(1), "Bricks across the depth.").required(),
                   field("jitter", &B::jitter, plain(below_overlap),
                         "Random shift of inner nodes as a fraction of the spacing."),
                   field("seed", &B::seed, integer(0), "Seed of the random shift."),
                   field("region", &B::region, text("a name"), "Region outside the inner regions."),
                   field("inner_regions", &B::inner_regions, list(inner_region),
                         "Regions in it; a later one counts where they overlap.")});
}

Codec<MeshParameters> mesh() {
  using M = MeshParameters;
  return block<M>(
      {alternative("file", &M::source, text("a file name"),
                   "Gmsh file, relative to the folder of the scene."),
       alternative("rectangle", &M::source, rectangle(), "A structured mesh of triangles."),
       alternative("box", &M::source, box(), "A structured mesh of tetrahedra, six a brick."),
       field("scale", &M::scale, plain(positive),
             "Multiplies the coordinates of a file: 0.001 for millimetres."),
       field("refine", &M::refine, integer(0),
             "Times that every triangle is split in four, or tetrahedron in eight.")},
      {{"file", "rectangle", "box"}});
}

// Tissue and what acts on it

Codec<LinearElastic> elastic() {
  using E = LinearElastic;
  const Range compressible{
      .min = 0, .max = 0.5, .max_open = true, .note = "0.5 is incompressible: take 0.4999"};
  return block<E>(
      {field("youngs_modulus", &E::youngs_modulus, number("Pa", positive), "Young's modulus.")
           .required(),
       field("poisson_ratio", &E::poisson_ratio, plain(compressible), "Poisson's ratio.")
           .required(),
       field("density", &E::density, number("kg/m^3", not_negative),
             "Mass per volume; 0 only if quasi_static.")
           .required()});
}

Codec<TissueParameters> tissue() {
  using T = TissueParameters;
  const Choices<Plane> planes = {{"stress", Plane::stress}, {"strain", Plane::strain}};
  const Choices<MassKind> masses = {{"consistent", MassKind::consistent},
                                    {"lumped", MassKind::lumped}};
  const Choices<Formulation> formulations = {
      {"p1", Formulation::p1}, {"p1_averaged", Formulation::p1_averaged}, {"p2", Formulation::p2}};
  const auto damping =
      block<RayleighDamping>({field("mass_factor", &RayleighDamping::mass_factor,
                                    number("1/s", not_negative), "Times the mass matrix."),
                              field("stiffness_factor", &RayleighDamping::stiffness_factor,
                                    number("s", not_negative), "Times the stiffness matrix.")});
  return block<T>(
      {field("plane", &T::plane, choice(planes), "Plane stress or plane strain of triangles.")
           .otherwise("required for triangles, not allowed for tetrahedra"),
       field("thickness", &T::thickness, number("m", positive), "Extent out of plane.")
           .written_if([](const T& given) { return given.plane.has_value(); }),
       field(
           "formulation", &T::formulation, choice(formulations),
           "Kind of triangle or tetrahedron; p1_averaged does not lock, nor does p2, the quadratic "
           "tetrahedron.")
           .otherwise("p1_averaged in plane strain or of tetrahedra with a poisson_ratio above "
                      "0.45, else p1"),
       field("mass", &T::mass, choice(masses), "Mass matrix.")
           .otherwise("lumped if time.method is explicit, else consistent"),
       field("regions", &T::regions,
             named("REGION", &RegionTissue::region, wrap(&RegionTissue::material, elastic())),
             "Material of every region of the mesh.")
           .required(),
       field("damping", &T::damping, damping, "Rayleigh damping; without it there is none.")});
}

std::vector<Field<Scene>> loads() {
  const auto body = block<BodyForce>(
      {field("force", &BodyForce::force, vector("N/m^3"), "Force per volume.").required(),
       field("start", &BodyForce::start, number("s", not_negative), "Acts from then on.")});
  const auto in_space = [](const Traction& given) { return given.force.z.has_value(); };
  const auto traction = block_with_rules<Traction>(
      {field("curve", &Traction::curve, text("a curve"), "Where it acts.")
           .otherwise("required but for a surface")
           .written_if(std::not_fn(in_space)),
       field("surface", &Traction::curve, text("a surface"), "Where it acts, on tetrahedra.")
           .otherwise("none")
           .written_if(in_space),
       field("force", &Traction::force, vector("N/m", Extent::plane), "Force per metre of curve.")
           .otherwise("required but for a surface")
           .written_if(std::not_fn(in_space)),
       field("stress", &Traction::force, vector("Pa", Extent::space), "Force per area of surface.")
           .otherwise("none")
           .written_if(in_space),
       field("start", &Traction::start, number("s", not_negative), "Acts from then on.")},
      {{{"curve", "surface"}}, {{"force", "stress"}}});
  return {field("body", &Scene::body_forces, list(body), "Forces on the volume, which add up."),
          field("traction", &Scene::tractions, list(traction),
                "Forces on named curves or surfaces, one each.")};
}

Codec<PrescribedCurve> prescribed() {
  using P = PrescribedCurve;
  const auto in_space = [](const P& given) { return given.displacement.size() == 3; };
  return block<P>({field("curve", &P::curve, text("a curve"), "What is moved.")
                       .otherwise("required but for a surface")
                       .written_if(std::not_fn(in_space)),
                   field("surface", &P::curve, text("a surface"), "What is moved, of tetrahedra.")
                       .otherwise("none")
                       .written_if(in_space),
                   field("displacement", &P::displacement, components("m"),
                         "[x, y] or [x, y, z]; a component that is null stays free.")
                       .required(),
                   field("start", &P::start, number("s", not_negative), "When it begins."),
                   field("ramp", &P::ramp, number("s", not_negative),
                         "Time to grow linearly to the full displacement; 0: at once.")},
                  {{"curve", "surface"}});
}

// Time and output

Codec<TimeParameters> time() {
  using T = TimeParameters;
  const Choices<TimeMethod> methods = {{"implicit", TimeMethod::implicit_newmark},
                                       {"explicit", TimeMethod::explicit_newmark},
                                       {"quasi_static", TimeMethod::quasi_static}};
  const Choices<ImplicitScheme> schemes = {
      {"average_acceleration", ImplicitScheme::average_acceleration},
      {"generalised_alpha", ImplicitScheme::generalised_alpha},
      {"backward_euler", ImplicitScheme::backward_euler}};
  const Range fraction{.min = 0, .max = 1};
  const Choices<bool> ends = {{"implanted", true}, {"settled", false}};
  return block<T>(
      {field("method", &T::method, choice(methods), "Implicit, explicit or without inertia."),
       field("scheme", &T::scheme, choice(schemes), "Scheme of the implicit method."),
       field("rho_infinity", &T::rho_infinity, plain(fraction),
             "Of generalised_alpha: 1 does not damp, 0 damps most."),
       field("step", &T::step, number("s", positive),
             "Length of a step; explicit ones are cut to the stable step."),
       field("duration", &T::duration, number("s", positive), "End of a scene without needles.")
           .otherwise("one step if quasi_static")
           .written_if([](const T& given) { return given.duration != 0; }),
       field("until", &T::until_implanted, choice(ends),
             "implanted: end at the last implant, where that gives the same placement."),
       field("safety", &T::safety, plain({.min = 0, .max = 1, .min_open = true}),
             "Explicit: step over stable step.")});
}

Codec<CheckpointParameters> checkpoint() {
  using C = CheckpointParameters;
  return block<C>(
      {field("steps", &C::steps, integer(1), "Steps of time.step between two."),
       field("wall_time", &C::wall_time, number("s", positive), "Time on the clock between two.")
           .otherwise("10 min if there are no steps"),
       field("keep", &C::keep, integer(1), "So many are kept, the newest."),
       field("at_end", &C::at_end, flag(), "One more when the run is done, to go on beyond it.")});
}

Codec<OutputParameters> output() {
  using O = OutputParameters;
  return block<O>(
      {field("directory", &O::directory, text("a folder"), "Where results go."),
       field("history", &O::history, flag(), "One line a step in history.csv."),
       field("snapshots", &O::snapshots, number("s", positive),
             "Time between whole fields in snapshots.h5; without it there are none."),
       field("checkpoint", &O::checkpoint, checkpoint(),
             "What run --resume goes on from; without it where a run is stopped only.")});
}

// A bound has the unit of its quantity; of a path that no summary has, check_rules will say so.
Field<Expectation> bound(const std::string& name,
                         double Expectation::*member,
                         const std::string& doc) {
  const auto codec_of = [](const Expectation& of) {
    return number_in_unit_or_plain(unit_of_quantity(of.quantity).value_or(""));
  };
  return {described(number_in_unit_or_plain("").key, name, doc),
          [=](const Node& node, Expectation& value) {
            if (unit_of_quantity(value.quantity)) codec_of(value).read(node, value.*member);
          },
          [=](const Expectation& value) -> std::optional<Node> {
            if (value.*member == Expectation{}.*member) return std::nullopt;
            return codec_of(value).write(value.*member);
          }};
}

Codec<Expectation> expectation() {
  using E = Expectation;
  return block<E>(
      {field("quantity", &E::quantity, path("a path in summary.json"), "A number of summary.json.")
           .required(),
       bound("min", &E::min, "Smallest value that passes.").otherwise("none"),
       bound("max", &E::max, "Largest value that passes.").otherwise("none")});
}

Codec<SupportKind> support() {
  return choice<SupportKind>({{"fixed", SupportKind::fixed},
                              {"roller", SupportKind::roller},
                              {"free", SupportKind::free}});
}

// What belongs to an interactive procedure

Codec<ProcedureParameters> procedure() {
  return block<ProcedureParameters>(
      {field("file", &ProcedureParameters::file, text("a file name"),
             "Rows of a recorded procedure, relative to the folder of the scene.")
           .required()});
}

Codec<ImageParameters> image() {
  using I = ImageParameters;
  return block<I>(
      {field("file", &I::file, text("a file name"),
             "PNG or JPEG, relative to the folder of the scene; without it a picture like "
             "ultrasound is made."),
       field("origin", &I::origin, point<ReferencePoint>("m"), "Lower left corner of a file."),
       field("size", &I::size, point<Vector2>("m", positive), "Width and height of a file."),
       field("seed", &I::seed, integer(0), "Of the speckle of a picture that is made."),
       field("attenuation", &I::attenuation, number("1/m", not_negative),
             "Loss of echo with the distance from the lower edge, where the probe lies."),
       field("shadow", &I::shadow, plain({.min = 0, .max = 1}),
             "Share of the echo that is lost behind the needle.")});
}

Codec<Scene> scene() {
  using S = Scene;
  return block<S>(
      {field("mesh", &S::mesh, mesh(), "Where triangles or tetrahedra come from.").required(),
       field("tissue", &S::tissue, tissue(), "What the tissue is made of.").required(),
       field("supports", &S::supports,
             named("CURVE", &Support::curve, wrap(&Support::kind, support())),
             "How named curves or surfaces are held; the others are free. Needles need tissue that "
             "is "
             "held."),
       group("loads", loads(), "Forces on the tissue."),
       field("prescribed", &S::prescribed, list(prescribed()),
             "Named curves that are moved; in a point of a support, the support holds."),
       field(
           "needle_angle", &S::needle_angle, number("rad", {.min = -7, .max = 7}),
           "Direction in which the needles advance, from +x counter-clockwise; pi: from the right.")
           .otherwise("180 degrees"),
       field("needles", &S::needles, list(needle_codec()), "One after the other."),
       field("membrane", &S::membrane, membrane_codec(), "A capsule that has to be punctured."),
       field("targets", &S::targets,
             named("TARGET", &Target::name, wrap(&Target::point, vector("m"))),
             "Where seeds should be."),
       field("probes", &S::probes, named("PROBE", &Probe::name, wrap(&Probe::point, vector("m"))),
             "Points whose displacement is recorded."),
       field("time", &S::time, time(), "How time is stepped."),
       field("output", &S::output, output(), "What is written."),
       field("expect", &S::expect, list(expectation()), "Makes the scene a test."),
       field("procedure", &S::procedure, procedure(), "A recorded hand, in the place of needles."),
       field("image", &S::image, image(), "Picture of the tissue, written as image.png."),
       field("start", &S::start,
             block<StartParameters>({field("from", &StartParameters::from, text("a file name"),
                                           "Checkpoint, relative to the folder of the scene.")
                                         .required()}),
             "Begin in the tissue, and at the time, where another run has left a checkpoint.")});
}

}  // namespace

const Codec<Scene>& scene_codec() {
  static const Codec<Scene> codec = scene();
  return codec;
}

}  // namespace stylet
