// Shapes by their names: `Geometry "teapot"`. All but the teapot fill the cube of side 1 around the origin, as the
// shapes of lights do, unless a parameter "radius" says otherwise.
#include <algorithm>
#include <cctype>
#include <cmath>

#include "geometry/build.h"
#include "geometry/makers.h"

namespace kinora::geometry {

namespace {

// Names of the shapes of lights. Where a light is declared the request belongs to it and is not seen here.
constexpr const char* kLightShapes[] = {"rectlight",    "disklight",   "spherelight", "cylinderlight",
                                        "distantlight", "portallight", "envsphere",   "domelight"};

scene::Parameter cornersOf(std::initializer_list<float> values) {
  scene::Parameter p;
  p.name = "P";
  p.storage = scene::StorageClass::Vertex;
  p.type = scene::ValueType::Point;
  p.floats = values;
  return p;
}

scene::PolygonMesh cubeFaces() {
  scene::PolygonMesh m;
  m.verticesPerLoop.assign(6, 4);
  m.vertices = {0, 3, 2, 1, 4, 5, 6, 7, 0, 1, 5, 4, 1, 2, 6, 5, 2, 3, 7, 6, 3, 0, 4, 7};
  return m;
}

}  // namespace

bool makeNamedShape(const scene::Primitive& primitive, const scene::OtherPrimitive& request, const DiceRate& rate,
                    Diagnostics& diagnostics, Mesh& mesh) {
  const std::string said = request.args.getString("type", "");
  std::string name = said;
  for (char& c : name) c = char(std::tolower(static_cast<unsigned char>(c)));

  // The request that it stands for, with its primvars. Who writes the name does not know how many faces there are: a
  // single value is meant for all.
  scene::Primitive shape = primitive;
  shape.motion.clear();
  shape.times.clear();
  std::vector<std::string> single;
  for (const scene::Parameter& p : primitive.primvars)
    if (p.storage != scene::StorageClass::Constant && p.size() == p.elementFloats()) single.push_back(p.name);
  for (const std::string& p : single) shape.primvars.find(p)->storage = scene::StorageClass::Constant;

  float radius = primitive.primvars.getFloat("radius", 0.5f);
  if (!(radius > 0) || !std::isfinite(radius)) {
    diagnostics.warning("GEOM-SHAPE-NAME", primitive.pos,
                        "the radius of Geometry '" + name.substr(0, 40) + "' is no number above 0", ".5 is used");
    radius = 0.5f;
  }
  if (name == "teapot") return makeTeapot(shape, rate, diagnostics, mesh);
  if (name == "cube" || name == "box") {
    shape.shape = cubeFaces();
    shape.primvars.set(cornersOf({-.5f, -.5f, -.5f, .5f, -.5f, -.5f, .5f, .5f, -.5f, -.5f, .5f, -.5f,
                                  -.5f, -.5f, .5f,  .5f, -.5f, .5f,  .5f, .5f, .5f,  -.5f, .5f, .5f}));
    return makePolygons(shape, std::get<scene::PolygonMesh>(shape.shape), diagnostics, mesh);
  }
  if (name == "plane") {
    shape.shape = scene::Patch{false};
    shape.primvars.set(cornersOf({-.5f, -.5f, 0, .5f, -.5f, 0, -.5f, .5f, 0, .5f, .5f, 0}));
    return makePatches(shape, rate, diagnostics, mesh);
  }
  using Kind = scene::Quadric::Kind;
  std::optional<scene::Quadric> quadric;
  if (name == "sphere") quadric = scene::Quadric{Kind::Sphere, {radius, -radius, radius, 360}};
  if (name == "cylinder") quadric = scene::Quadric{Kind::Cylinder, {radius, -.5f, .5f, 360}};
  if (name == "disk") quadric = scene::Quadric{Kind::Disk, {0, radius, 360}};
  if (quadric) {
    shape.shape = *quadric;
    return makeQuadric(shape, *quadric, rate, diagnostics, mesh);
  }
  const bool isLight = std::find(std::begin(kLightShapes), std::end(kLightShapes), name) != std::end(kLightShapes);
  diagnostics.warning("GEOM-SHAPE-NAME", primitive.pos,
                      isLight ? "Geometry '" + name + "' is the shape of a light, and no light is declared for it"
                              : "no Geometry is called '" + said.substr(0, 40) + "'",
                      "it is left out", isLight ? "" : "known are teapot, cube, sphere, cylinder, disk and plane");
  return false;
}

}  // namespace kinora::geometry
