// The scene description: what a scene *says*, typed, editable, with source positions. Written by rib/ (and by tests
// and later by bindings), read by render/. It holds no BVH, no loaded plug-in and no opinion on what can be rendered.
// Every type here lists its fields in scene/fields.h; one that is forgotten there does not compile.
// What things share is const: an edit puts another one in its place. Whoever keeps what was made of a thing may so
// hold it and know it again by its address.
// Space convention: row vectors, p' = p * M (RIB's and Imath's); transforms are double precision.
#pragma once
#include <ImathMatrix.h>
#include <array>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "scene/instance_list.h"
#include "scene/keys.h"
#include "scene/lean_vector.h"
#include "scene/parameters.h"

namespace kinora::scene {

using Matrix = Imath::M44d;

// A transform over shutter time: one matrix when static, else matrices at increasing times, linear in between, held
// outside. Rotations are cut into enough keys by the writer that linear interpolation is good to 1e-4 of the radius.
struct Transform {
  Keys<double> times;     // as made: 0
  Keys<Matrix> matrices;  // as made: the identity
  bool isStatic() const { return matrices.size() == 1; }
  Matrix at(double time) const;
  Transform inverse() const;  // key by key
  static Transform fixed(const Matrix& m);
  // Renderers use a tenth of them, and without a bound a short file whose blocks nest would
  // have more with each object than fit into memory.
  static constexpr size_t kMostKeys = 1024;
};
// x -> x * a(t) * b(t), at the union of both key times and as many between them as its 1e-4 takes; at kMostKeys of them
// where these are more and both move.
Transform concat(const Transform& a, const Transform& b);

// A use of a plug-in: Bxdf, Pattern, Light, LightFilter, Integrator, Projection, SampleFilter, DisplayFilter,
// Displace.
struct Node {
  std::string kind;    // the request's name: "Bxdf", "Pattern", "Light", "Displace", ...
  std::string plugin;  // as written; matched without case
  std::string handle;
  ParameterList params;
  SourcePos pos;
};
using NodePtr = std::shared_ptr<const Node>;

// A terminal and the patterns reachable from it, in an order in which each node follows those it reads.
struct Network {
  NodePtr terminal;
  std::vector<NodePtr> patterns;
};
using NetworkPtr = std::shared_ptr<const Network>;

// Attributes "group:name" plus the classic state. Shared by all objects between two changes (copy on write).
struct Attributes {
  ParameterList named;                                 // "identifier:name", "visibility:camera", "user:x", ...
  std::optional<std::array<float, 3>> color, opacity;  // Color, Opacity requests
  std::array<float, 8> textureCoordinates{0, 0, 1, 0, 0, 1, 1, 1};
  bool reverseOrientation = false;  // ReverseOrientation toggles
  // The handed ones as if they had been said in world space (in an object: in its space): a transform that mirrors
  // takes the orientation along, so that only those before the request decide whether it turns a shape inside out.
  enum class Orientation : uint8_t { Outside, Inside, LeftHanded, RightHanded } orientation = Orientation::Outside;
  int sides = 2;
  bool matte = false;
  bool smoothShading = true;  // ShadingInterpolation
  float shadingRate = 1;
  static constexpr std::array<float, 16> kBezier{-1, 3, -3, 1, 3, -6, 3, 0, -3, 3, 0, 0, 1, 0, 0, 0};
  std::array<float, 16> uBasis = kBezier, vBasis = kBezier;  // RIB row-major, see rib.md 7.3
  int uStep = 3, vStep = 3;
  NetworkPtr bxdf, displacement;  // null: none bound
  // LightSource: ids of those that shine here, in rising order; null: none. Light shines everywhere but where
  // "illuminate:off" names it.
  std::shared_ptr<const std::vector<uint32_t>> lightSources;
  std::vector<NodePtr> classicShaders;  // Surface, Displacement, Atmosphere, Interior, Exterior as written, kept
  // ScopedCoordinateSystem: name -> (that space to world) for nodes in this scope; asked before Scene's. Null: none.
  std::shared_ptr<const std::map<std::string, Transform>> coordinateSystems;
  // Which of the above some request set, where the value alone does not show it; says() knows those that differ from
  // the default without having been noted here.
  enum Given : uint16_t {
    kTextureCoordinates = 1,
    kOrientation = 2,
    kReverseOrientation = 4,  // to a value: `Attribute "Ri"`, not toggled
    kSides = 8,
    kMatte = 16,
    kShadingInterpolation = 32,
    kShadingRate = 64
  };
  uint16_t given = 0;
  bool says(Given what) const;
  int getInt(std::string_view name, int fallback) const { return named.getInt(name, fallback); }
};
using AttributesPtr = std::shared_ptr<const Attributes>;

// Attributes of what stands in an object, as its instance gives them: those that were set inside the object, all
// others from the instance (RISpec 5.9). Bases belong to the points, so they are always the object's.
AttributesPtr inherit(const AttributesPtr& own, const AttributesPtr& instance);

// Under MotionBegin a quadric whose arguments move has them as "constant float[n] __quadric" in each list of
// `motion`.
struct Quadric {
  enum class Kind : uint8_t { Sphere, Cone, Cylinder, Hyperboloid, Paraboloid, Disk, Torus } kind;
  std::array<float, 7> args;  // in the order of the request
};
// All four polygon requests: face f has loopsPerFace[f] loops (empty vector: one each), the first the outer one.
struct PolygonMesh {
  LeanVector<int> loopsPerFace;
  std::vector<int> verticesPerLoop;
  std::vector<int> vertices;  // empty: 0, 1, 2 ... (Polygon, GeneralPolygon)
};
struct SubdivisionMesh {
  std::string scheme;  // "catmull-clark", "loop", "bilinear"
  std::vector<int> verticesPerFace, vertices;
  struct Tag {
    std::string name;
    std::vector<int> ints;
    std::vector<float> floats;
    std::vector<std::string> strings;
  };
  LeanVector<Tag> tags;
};
struct Curves {
  bool cubic = false, periodic = false;
  std::vector<int> verticesPerCurve;
};
struct Points {
  int count = 0;
};
struct Patch {
  bool bicubic = false;
};
struct PatchMesh {
  bool bicubic = false, uPeriodic = false, vPeriodic = false;
  int nu = 0, nv = 0;
};
struct NuPatch {
  int nu = 0, uOrder = 0, nv = 0, vOrder = 0;
  LeanVector<float> uKnots, vKnots;
  float uMin = 0, uMax = 1, vMin = 0, vMax = 1;
  ParameterList trim;  // TrimCurve arrays by their names in rib.md, empty when untrimmed
};
// Blobby, and everything that is not rendered yet (Volume, Procedural, Geometry ...), as its request and arguments.
struct OtherPrimitive {
  std::string request;
  ParameterList args;
};

using Shape =
    std::variant<Quadric, PolygonMesh, SubdivisionMesh, Curves, Points, Patch, PatchMesh, NuPatch, OtherPrimitive>;
const char* requestName(const Shape& shape);  // "Sphere"

// A block of SolidBegin ... SolidEnd, a node of a tree of constructive solid geometry. Surfaces stand in blocks of
// Primitive alone: one that stands in a block of an operation has a block of its own.
struct Solid {
  enum class Operation : uint8_t { Primitive, Union, Intersection, Difference } operation = Operation::Primitive;
  uint32_t parent = 0;  // the solid that it is an operand of, see Primitive::solid; before it in its list. 0: none
  SourcePos pos;
  bool operator==(const Solid& o) const { return operation == o.operation && parent == o.parent; }
};

// One primitive. `primvars` are those of the first motion key; `motion` those of the further keys at times[1..].
struct Primitive {
  uint32_t id = 0;  // stable over edits, unique in the scene, from 1
  Shape shape;
  ParameterList primvars;
  LeanVector<double> times;          // empty: no deformation
  LeanVector<ParameterList> motion;  // times.size() - 1 of them
  Transform toWorld;                 // object -> world (inside a prototype: object -> prototype space)
  AttributesPtr attributes;
  uint32_t solid = 0;  // that it bounds a part of: place in `solids` of the scene or the prototype, from 1; 0: none
  SourcePos pos;
  std::string givenName() const;  // identifier:name, identifier:object; "" without
  std::string name() const;       // that, else "Sphere at file.rib:12"
};
using PrimitivePtr = std::shared_ptr<const Primitive>;

struct Light {
  uint32_t id = 0;
  NodePtr node;
  std::vector<NodePtr> filters;
  std::vector<Transform> filterToWorld;  // one a filter: the space it was declared in
  std::vector<NodePtr> patterns;         // network feeding connectable parameters, in order
  Transform toWorld;
  AttributesPtr attributes;
  std::optional<Primitive> geometry;  // the geometry that emits: PxrMeshLight's, AreaLightSource's
};

struct Instance {
  uint32_t id = 0;
  uint32_t prototype = 0;    // index into Scene::prototypes
  Transform toWorld;         // (inside a prototype: to that prototype's space)
  AttributesPtr attributes;  // those at the ObjectInstance request
  uint32_t solid = 0;        // as of a primitive
  SourcePos pos;
};
// ObjectBegin ... ObjectEnd. Attributes inside begin at their defaults, whatever stood before ObjectBegin. Nested
// instances are kept as said; flattening is the renderer's business.
struct Prototype {
  std::string name;
  std::vector<PrimitivePtr> primitives;
  InstanceList instances;
  std::vector<Light> lights;  // LightSource and AreaLightSource too; shapes of lights are none of `primitives`
  std::vector<Solid> solids;
  SourcePos pos;
};

struct Camera {
  std::string name;
  Transform worldToCamera;
  NodePtr projection;    // null: orthographic; plug-in "perspective"/"orthographic"/"PxrCamera" ...
  ParameterList params;  // Camera request: shutteropening, apertureNSides ...
  std::array<float, 4> screenWindow{0, 0, 0, 0};  // left right bottom top; all 0: default
  std::array<double, 2> shutter{0, 0};
  std::array<float, 3> depthOfField{0, 0, 0};  // fstop, focallength, focaldistance; fstop 0: pinhole
  std::array<float, 2> clipping{0, 0};         // 0 0: default
  // ClippingPlane: point and normal in camera space; what the normal points to is cut away.
  std::vector<std::array<double, 6>> clippingPlanes;
  SourcePos pos;
};

struct DisplayChannel {
  std::string name;
  ValueType type = ValueType::Color;
  int arrayLength = 1;
  ParameterList params;
  SourcePos pos;
};
struct Display {
  std::string file, driver, mode;  // mode as written: "rgba", "Ci,a,diffuse"
  ParameterList params;
  SourcePos pos;
};

// A request that was read but that nothing renders yet; reported once by its name.
struct KeptRequest {
  std::string request;
  std::vector<std::string> args;
  ParameterList params;
  SourcePos pos;
};

// What the description holds, for --stats and `kinora info`.
struct SceneStatistics {
  size_t primitives = 0;  // outside and inside prototypes
  size_t instances = 0, prototypes = 0, lights = 0, kept = 0;
  size_t faces = 0;  // of polygon and subdivision meshes
  size_t bytes = 0;  // memory held
};

struct Scene {
  int frame = 0;                        // FrameBegin's number; see hasFrame
  bool hasFrame = false;                // inside FrameBegin ... FrameEnd
  ParameterList options;                // "group:name"
  std::array<int, 2> resolution{0, 0};  // Format; 0: default
  float pixelAspect = 1, frameAspect = -1;
  std::array<float, 4> cropWindow{0, 1, 0, 1};  // xmin xmax ymin ymax
  std::string pixelFilter = "gaussian";
  std::array<float, 2> pixelFilterWidth{2, 2};
  float pixelVariance = -1;
  std::array<int, 2> pixelSamples{0, 0};  // PixelSamples; 0: unset
  std::array<float, 2> exposure{1, 1};    // gain, gamma
  NodePtr hider, integrator;
  std::vector<NodePtr> sampleFilters, displayFilters;
  std::vector<Display> displays;
  std::vector<DisplayChannel> channels;
  std::vector<Camera> cameras;  // the first is the primary one
  std::vector<PrimitivePtr> primitives;
  InstanceList instances;
  std::vector<Prototype> prototypes;
  std::vector<Solid> solids;
  std::vector<Light> lights;
  std::vector<Light> classicLights;  // LightSource and AreaLightSource as said; `node->kind` tells which
  std::map<std::string, Transform> coordinateSystems;  // name -> (that space to world)
  std::vector<KeptRequest> kept;
  SourcePos pos;  // of WorldBegin
  uint32_t nextId = 1;

  // Edits. What they touch becomes another object, so that whoever holds the old one keeps it; unknown ids are
  // reported by false.
  bool setPrimitiveTransform(uint32_t id, const Transform& t);
  bool setPrimitiveAttributes(uint32_t id, AttributesPtr a);
  bool replacePrimitive(uint32_t id, Primitive p);
  bool removePrimitive(uint32_t id);
  bool setInstanceTransform(uint32_t id, const Transform& t);
  bool setLight(uint32_t id, Light l);
  bool setCamera(size_t index, Camera c);
  uint32_t add(Primitive p);  // returns the id given
  uint32_t add(Light l);
  uint32_t add(Instance i);
  size_t bytes() const;  // memory held, for the statistics
  SceneStatistics statistics() const;
};

}  // namespace kinora::scene
