// Each type of the description with its fields, once. Hashing, naming differences, counting memory, editing in tests:
// whoever goes through a description goes through these lists, so that a new field is in all of them or the
// program does not compile. Included by few sources: lists are templates.
#pragma once
#include <cstddef>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <utility>

#include "scene/scene.h"

namespace kinora::scene {

// What a field has to do with pixels.
enum class Counts : uint8_t {
  Always,
  Never,   // a name for people, a place in a file, the book-keeping of edits
  ByPlace  // the id of another thing: what counts is which one of the scene that is, not its number
};

template <class T, class M, Counts C = Counts::Always, bool IsPart = false>
struct Field {
  using Owner = T;
  using Member = M;
  static constexpr Counts kCounts = C;
  // Its own fields are said to be the owner's: "sides", not "attributes: sides".
  static constexpr bool kIsPart = IsPart;
  std::string_view name;  // in messages
  M T::*member;
  bool (*isCounted)(const Parameter& one) = nullptr;  // of a list of parameters; null: all are
};

template <class T, class M>
constexpr Field<T, M> field(std::string_view name, M T::*member) {
  return {name, member};
}
template <class T, class M>
constexpr Field<T, M, Counts::Always, true> part(std::string_view name, M T::*member) {
  return {name, member};
}
template <class T, class M>
constexpr Field<T, M, Counts::Never> note(std::string_view name, M T::*member) {
  return {name, member};
}
template <class T, class M>
constexpr Field<T, M, Counts::ByPlace> link(std::string_view name, M T::*member) {
  return {name, member};
}
// A list of which some parameters decide no pixel.
template <class T>
constexpr Field<T, ParameterList> some(std::string_view name, ParameterList T::*member,
                                       bool (*isCounted)(const Parameter&)) {
  return {name, member, isCounted};
}

// Options that say where files are sought (what is found there counts by its content), how a file was to be parsed,
// in what order and with what memory a frame is rendered, and what is reported of it.
bool optionDecidesPixels(const Parameter& option);

template <class T>
inline constexpr auto kFields = nullptr;  // not a type of the description

template <>
inline constexpr auto kFields<Transform> = std::tuple(field("times", &Transform::times),
                                                      field("matrices", &Transform::matrices));

template <>
inline constexpr auto kFields<Parameter> = std::tuple(
    field("name", &Parameter::name), field("storage class", &Parameter::storage), field("type", &Parameter::type),
    field("reference", &Parameter::isReference), field("array", &Parameter::isArray),
    field("array length", &Parameter::arrayLength), field("floats", &Parameter::floats),
    field("ints", &Parameter::ints), field("strings", &Parameter::strings), note("place", &Parameter::pos));

template <>
inline constexpr auto kFields<Node> = std::tuple(field("kind", &Node::kind), field("plug-in", &Node::plugin),
                                                 field("handle", &Node::handle), field("parameter", &Node::params),
                                                 note("place", &Node::pos));

template <>
inline constexpr auto kFields<Network> = std::tuple(part("terminal", &Network::terminal),
                                                    part("patterns", &Network::patterns));

template <>
inline constexpr auto kFields<Attributes> = std::tuple(
    field("attribute", &Attributes::named), field("color", &Attributes::color),
    field("opacity", &Attributes::opacity), field("texture coordinates", &Attributes::textureCoordinates),
    field("reversed orientation", &Attributes::reverseOrientation), field("orientation", &Attributes::orientation),
    field("sides", &Attributes::sides), field("matte", &Attributes::matte),
    field("shading interpolation", &Attributes::smoothShading), field("shading rate", &Attributes::shadingRate),
    field("u basis", &Attributes::uBasis), field("v basis", &Attributes::vBasis), field("u step", &Attributes::uStep),
    field("v step", &Attributes::vStep), part("material", &Attributes::bxdf),
    part("displacement", &Attributes::displacement), link("light sources", &Attributes::lightSources),
    part("shaders", &Attributes::classicShaders), field("coordinate system", &Attributes::coordinateSystems),
    field("what is set", &Attributes::given));

template <>
inline constexpr auto kFields<Quadric> = std::tuple(field("kind", &Quadric::kind), field("size", &Quadric::args));

template <>
inline constexpr auto kFields<PolygonMesh> = std::tuple(field("loops", &PolygonMesh::loopsPerFace),
                                                        field("faces", &PolygonMesh::verticesPerLoop),
                                                        field("vertices", &PolygonMesh::vertices));

template <>
inline constexpr auto kFields<SubdivisionMesh::Tag> = std::tuple(field("name", &SubdivisionMesh::Tag::name),
                                                                 field("ints", &SubdivisionMesh::Tag::ints),
                                                                 field("floats", &SubdivisionMesh::Tag::floats),
                                                                 field("strings", &SubdivisionMesh::Tag::strings));

template <>
inline constexpr auto kFields<SubdivisionMesh> = std::tuple(field("scheme", &SubdivisionMesh::scheme),
                                                            field("faces", &SubdivisionMesh::verticesPerFace),
                                                            field("vertices", &SubdivisionMesh::vertices),
                                                            part("tags", &SubdivisionMesh::tags));

template <>
inline constexpr auto kFields<Curves> = std::tuple(field("type", &Curves::cubic), field("wrap", &Curves::periodic),
                                                   field("vertices of curves", &Curves::verticesPerCurve));

template <>
inline constexpr auto kFields<Points> = std::tuple(field("count", &Points::count));

template <>
inline constexpr auto kFields<Patch> = std::tuple(field("type", &Patch::bicubic));

template <>
inline constexpr auto kFields<PatchMesh> = std::tuple(field("type", &PatchMesh::bicubic),
                                                      field("wrap in u", &PatchMesh::uPeriodic),
                                                      field("wrap in v", &PatchMesh::vPeriodic),
                                                      field("vertices in u", &PatchMesh::nu),
                                                      field("vertices in v", &PatchMesh::nv));

template <>
inline constexpr auto kFields<NuPatch> = std::tuple(
    field("vertices in u", &NuPatch::nu), field("order in u", &NuPatch::uOrder), field("vertices in v", &NuPatch::nv),
    field("order in v", &NuPatch::vOrder), field("knots in u", &NuPatch::uKnots),
    field("knots in v", &NuPatch::vKnots), field("least u", &NuPatch::uMin), field("most u", &NuPatch::uMax),
    field("least v", &NuPatch::vMin), field("most v", &NuPatch::vMax), field("trim curves", &NuPatch::trim));

template <>
inline constexpr auto kFields<OtherPrimitive> = std::tuple(field("request", &OtherPrimitive::request),
                                                           field("argument", &OtherPrimitive::args));

template <>
inline constexpr auto kFields<Solid> = std::tuple(field("operation", &Solid::operation),
                                                  field("operand of", &Solid::parent), note("place", &Solid::pos));

template <>
inline constexpr auto kFields<Primitive> =
    std::tuple(note("id", &Primitive::id), part("shape", &Primitive::shape), field("primvar", &Primitive::primvars),
               field("times of deformation", &Primitive::times), field("deformed primvars", &Primitive::motion),
               field("transform", &Primitive::toWorld), part("attributes", &Primitive::attributes),
               field("solid", &Primitive::solid), note("place", &Primitive::pos));

template <>
inline constexpr auto kFields<Light> = std::tuple(
    note("id", &Light::id), part("node", &Light::node), part("filters", &Light::filters),
    field("filter's transform", &Light::filterToWorld), part("patterns", &Light::patterns),
    field("transform", &Light::toWorld), part("attributes", &Light::attributes), part("geometry", &Light::geometry));

template <>
inline constexpr auto kFields<Instance> = std::tuple(note("id", &Instance::id), field("object", &Instance::prototype),
                                                     field("transform", &Instance::toWorld),
                                                     part("attributes", &Instance::attributes),
                                                     field("solid", &Instance::solid), note("place", &Instance::pos));

template <>
inline constexpr auto kFields<Prototype> = std::tuple(field("name", &Prototype::name),
                                                      part("primitives", &Prototype::primitives),
                                                      part("instances", &Prototype::instances),
                                                      part("lights", &Prototype::lights),
                                                      part("solids", &Prototype::solids),
                                                      note("place", &Prototype::pos));

template <>
inline constexpr auto kFields<Camera> =
    std::tuple(field("name", &Camera::name), field("transform", &Camera::worldToCamera),
               part("projection", &Camera::projection), field("parameter", &Camera::params),
               field("screen window", &Camera::screenWindow), field("shutter", &Camera::shutter),
               field("depth of field", &Camera::depthOfField), field("clipping", &Camera::clipping),
               field("clipping planes", &Camera::clippingPlanes), note("place", &Camera::pos));

template <>
inline constexpr auto kFields<DisplayChannel> = std::tuple(field("name", &DisplayChannel::name),
                                                           field("type", &DisplayChannel::type),
                                                           field("array length", &DisplayChannel::arrayLength),
                                                           field("parameter", &DisplayChannel::params),
                                                           note("place", &DisplayChannel::pos));

// Where a picture goes does not decide what it shows.
template <>
inline constexpr auto kFields<Display> = std::tuple(note("file", &Display::file), field("driver", &Display::driver),
                                                    field("mode", &Display::mode),
                                                    field("parameter", &Display::params),
                                                    note("place", &Display::pos));

template <>
inline constexpr auto kFields<KeptRequest> = std::tuple(field("request", &KeptRequest::request),
                                                        field("arguments", &KeptRequest::args),
                                                        field("parameter", &KeptRequest::params),
                                                        note("place", &KeptRequest::pos));

// The number of a frame is compared by itself; two frames of one number may be one frame.
template <>
inline constexpr auto kFields<Scene> = std::tuple(
    note("frame", &Scene::frame), note("inside a frame", &Scene::hasFrame),
    some("option", &Scene::options, &optionDecidesPixels), field("resolution", &Scene::resolution),
    field("pixel aspect", &Scene::pixelAspect), field("frame aspect", &Scene::frameAspect),
    field("crop window", &Scene::cropWindow), field("pixel filter", &Scene::pixelFilter),
    field("width of the pixel filter", &Scene::pixelFilterWidth), field("pixel variance", &Scene::pixelVariance),
    field("pixel samples", &Scene::pixelSamples), field("exposure", &Scene::exposure), part("hider", &Scene::hider),
    part("integrator", &Scene::integrator), part("sample filters", &Scene::sampleFilters),
    part("display filters", &Scene::displayFilters), part("displays", &Scene::displays),
    part("channels", &Scene::channels), part("cameras", &Scene::cameras), part("primitives", &Scene::primitives),
    part("objects", &Scene::prototypes), part("solids", &Scene::solids), part("instances", &Scene::instances),
    part("lights", &Scene::lights), part("light sources", &Scene::classicLights),
    field("coordinate system", &Scene::coordinateSystems), part("other requests", &Scene::kept),
    note("place", &Scene::pos), note("next id", &Scene::nextId));

template <class T>
concept Described = !std::is_same_v<decltype(kFields<std::remove_const_t<T>>), const std::nullptr_t>;

namespace detail {

template <class T>
struct IsOptional : std::false_type {};
template <class T>
struct IsOptional<std::optional<T>> : std::true_type {};

// Becomes a value of any type. An optional takes it for its value.
struct Anything {
  template <class T>
  requires(!IsOptional<T>::value) operator T() const;
};
template <class T, size_t... I>
constexpr bool takes(std::index_sequence<I...>) {
  return requires { T{(void(I), Anything())...}; };
}
// The fields of an aggregate: the most initialisers that it takes.
template <class T, size_t N = 1>
constexpr size_t fieldCount() {
  if constexpr (takes<T>(std::make_index_sequence<N + 1>()))
    return fieldCount<T, N + 1>();
  else
    return N;
}
template <class T>
constexpr bool namesDiffer() {
  return std::apply(
      [](const auto&... f) {
        const std::string_view names[] = {f.name...};
        for (size_t i = 0; i < sizeof...(f); ++i)
          for (size_t j = 0; j < i; ++j)
            if (names[i] == names[j]) return false;
        return true;
      },
      kFields<T>);
}

}  // namespace detail

// Calls f(field, object.*field.member) for each field in order.
template <Described T, class F>
void forEachField(T& object, F&& f) {
  using Plain = std::remove_const_t<T>;
  static_assert(detail::fieldCount<Plain>() == std::tuple_size_v<std::remove_const_t<decltype(kFields<Plain>)>>,
                "a field of this type is missing in its list in scene/fields.h");
  static_assert(detail::namesDiffer<Plain>(), "two fields of this type have one name in scene/fields.h");
  std::apply([&](const auto&... each) { (f(each, object.*each.member), ...); }, kFields<Plain>);
}

}  // namespace kinora::scene
