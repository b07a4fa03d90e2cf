#include "scenes.h"

#include <OpenImageIO/imagebuf.h>
#include <OpenImageIO/imagebufalgo.h>

#include <cmath>
#include <cstdlib>
#include <random>
#include <stdexcept>

namespace kinora::bench {

namespace {

// 0..1, smooth, with features from a third of the room down to a thirtieth.
double bump(const double p[3]) {
  double sum = 0, most = 0, frequency = 3, gain = 1;
  for (int octave = 0; octave < 4; ++octave) {
    sum += gain * std::sin(frequency * p[0] + 1.3 * octave) * std::sin(frequency * p[1] + 0.7) *
           std::sin(frequency * p[2] + 2.1 * octave);
    most += gain;
    frequency *= 2.17;
    gain *= 0.55;
  }
  return 0.5 + 0.5 * sum / most;
}

scene::Parameter numbers(const std::string& name, scene::ValueType type, std::vector<float> values) {
  scene::Parameter p;
  p.name = name;
  p.type = type;
  p.floats = std::move(values);
  return p;
}

scene::Parameter reference(const std::string& name, scene::ValueType type, const std::string& from) {
  scene::Parameter p;
  p.name = name;
  p.type = type;
  p.isReference = true;
  p.strings = {from};
  return p;
}

// The surface material with references instead of some of its values.
scene::NodePtr surface(const std::vector<scene::Parameter>& connected) {
  auto n = std::make_shared<scene::Node>(*node("Bxdf", "PxrSurface", "surface", kAllLobes));
  for (const scene::Parameter& p : connected) n->params.set(p);
  return n;
}

}  // namespace

#define ALL_BUT_GLASS                                                                                              \
  "diffuseGain=1; diffuseColor=0.6 0.5 0.4; diffuseRoughness=0.5; diffuseDoubleSided=1; "                          \
  "specularFresnelMode=1; specularEdgeColor=1 1 1; specularIor=1.5 1.5 1.5; specularExtinctionCoeff=0.3 0.2 0.1; " \
  "specularRoughness=0.3; specularModelType=1; specularDoubleSided=1; "                                            \
  "roughSpecularFaceColor=0.05 0.06 0.07; roughSpecularEdgeColor=0.3 0.3 0.3; roughSpecularRoughness=0.6; "        \
  "roughSpecularModelType=1; roughSpecularDoubleSided=1; "                                                         \
  "clearcoatFaceColor=0.04 0.04 0.04; clearcoatEdgeColor=1 1 1; clearcoatRoughness=0.15; clearcoatModelType=1; "   \
  "clearcoatDoubleSided=1; clearcoatThickness=0.3; clearcoatAbsorptionTint=0.3 0.2 0.1; "                          \
  "specularEnergyCompensation=1; clearcoatEnergyCompensation=1; "                                                  \
  "fuzzGain=0.3; fuzzColor=0.9 0.8 0.7; fuzzConeAngle=15; fuzzDoubleSided=1"
const char* const kAllButGlass = ALL_BUT_GLASS;
const char* const kAllLobes = ALL_BUT_GLASS
    "; diffuseTransmitGain=0.2; refractionGain=0.2; reflectionGain=0.2; glassRoughness=0.3; glassIor=1.4";
#undef ALL_BUT_GLASS

TriangleMesh bumpyRoom(size_t triangles, float size) {
  const int n = std::max(1, int(std::lround(std::sqrt(double(triangles) / 12))));
  TriangleMesh m;
  m.points.reserve(size_t(6) * (n + 1) * (n + 1) * 3);
  m.vertices.reserve(size_t(36) * n * n);
  for (int face = 0; face < 6; ++face) {
    const int axis = face / 2;
    const double side = face % 2 ? 1 : -1;
    const int first = int(m.points.size() / 3);
    for (int j = 0; j <= n; ++j)
      for (int i = 0; i <= n; ++i) {
        double p[3];
        p[axis] = side;
        p[(axis + 1) % 3] = -1 + 2.0 * i / n;
        p[(axis + 2) % 3] = -1 + 2.0 * j / n;
        const double scale = size * (1 - 0.45 * bump(p));
        for (double x : p) m.points.push_back(float(x * scale));
      }
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i) {
        const int a = first + j * (n + 1) + i, b = a + 1, c = a + n + 2, d = a + n + 1;
        m.vertices.insert(m.vertices.end(), {a, b, c, a, c, d});
      }
  }
  return m;
}

TriangleMesh sheet(float x0, float y0, float x1, float y1, float z) {
  return {{x0, y0, z, x1, y0, z, x1, y1, z, x0, y1, z}, {0, 1, 2, 0, 2, 3}};
}

scene::ParameterList parameters(const std::string& text) {
  scene::ParameterList list;
  size_t at = 0;
  while (at < text.size()) {
    const size_t end = std::min(text.find(';', at), text.size()), equals = text.find('=', at);
    const size_t start = text.find_first_not_of(' ', at);
    std::vector<float> values;
    const char* s = text.c_str() + equals + 1;
    for (char* next = nullptr; s < text.c_str() + end; s = next) {
      const float v = std::strtof(s, &next);
      if (next == s) break;
      values.push_back(v);
    }
    list.set(numbers(text.substr(start, equals - start),
                     values.size() == 3 ? scene::ValueType::Color : scene::ValueType::Float, values));
    at = end + 1;
  }
  return list;
}

scene::NodePtr node(const std::string& kind, const std::string& plugin, const std::string& handle,
                    const std::string& params) {
  auto n = std::make_shared<scene::Node>();
  n->kind = kind;
  n->plugin = plugin;
  n->handle = handle;
  n->params = parameters(params);
  return n;
}

scene::NetworkPtr material(const std::string& plugin, const std::string& handle, const std::string& params) {
  auto n = std::make_shared<scene::Network>();
  n->terminal = node("Bxdf", plugin, handle, params);
  return n;
}

scene::NetworkPtr fractalSurface() {
  auto n = std::make_shared<scene::Network>();
  n->patterns = {
      node("Pattern", "PxrFractal", "colours", "frequency=4; colorScale=0.7 0.5 0.3; colorOffset=0.2 0.2 0.2"),
      node("Pattern", "PxrFractal", "roughness", "frequency=9; layers=4; floatScale=0.5; floatOffset=0.1")};
  n->terminal = surface({reference("diffuseColor", scene::ValueType::Color, "colours:resultRGB"),
                         reference("specularRoughness", scene::ValueType::Float, "roughness:resultF")});
  return n;
}

scene::NetworkPtr texturedSurface(const std::vector<std::string>& files) {
  auto n = std::make_shared<scene::Network>();
  for (size_t i = 0; i < files.size(); ++i) {
    auto t = std::make_shared<scene::Node>(*node("Pattern", "PxrTexture", "texture" + std::to_string(i), "filter=1"));
    scene::Parameter p;
    p.name = "filename";
    p.type = scene::ValueType::String;
    p.strings = {files[i]};
    t->params.set(p);
    n->patterns.push_back(t);
  }
  n->terminal = surface({reference("diffuseColor", scene::ValueType::Color, "texture0:resultRGB"),
                         reference("specularRoughness", scene::ValueType::Float, "texture1:resultR"),
                         reference("roughSpecularFaceColor", scene::ValueType::Color, "texture2:resultRGB"),
                         reference("fuzzColor", scene::ValueType::Color, "texture3:resultRGB")});
  return n;
}

std::vector<std::string> writePictures(const std::string& folder) {
  std::vector<std::string> files;
  for (int k = 0; k < 4; ++k) {
    constexpr int kSize = 512;
    OIIO::ImageBuf picture(OIIO::ImageSpec(kSize, kSize, 3, OIIO::TypeDesc::UINT8));
    for (int y = 0; y < kSize; ++y)
      for (int x = 0; x < kSize; ++x) {
        const uint32_t h = uint32_t(x) * 73856093u ^ uint32_t(y) * 19349663u ^ uint32_t(k) * 83492791u;
        const float v = 0.3f + 0.4f * float((h * 2654435761u) >> 24) / 255.f,
                    w = 0.2f * float((x / 32 + y / 32 + k) % 2);
        const float rgb[3] = {v, v * 0.8f + w, 0.5f * v};
        picture.setpixel(x, y, rgb);
      }
    const std::string file = folder + "/picture" + std::to_string(k) + ".tx";
    if (!OIIO::ImageBufAlgo::make_texture(OIIO::ImageBufAlgo::MakeTxTexture, picture, file, OIIO::ImageSpec()))
      throw std::runtime_error("'" + file + "' cannot be written");
    files.push_back(file);
  }
  return files;
}

void addMesh(scene::Scene& scene, const TriangleMesh& mesh, const scene::NetworkPtr& material) {
  scene::Primitive p;
  scene::PolygonMesh polygons;
  polygons.verticesPerLoop.assign(mesh.triangleCount(), 3);
  polygons.vertices = mesh.vertices;
  p.shape = std::move(polygons);
  scene::Parameter points = numbers("P", scene::ValueType::Point, mesh.points);
  points.storage = scene::StorageClass::Vertex;
  p.primvars.set(std::move(points));
  auto attributes = std::make_shared<scene::Attributes>();
  attributes->bxdf = material;
  p.attributes = attributes;
  scene.add(std::move(p));
}

CurveSet scatteredHairs(size_t pieces) {
  CurveSet c;
  std::mt19937 random(7);
  const auto unit = [&] { return 2 * float(random() >> 8) / 16777216.f - 1; };
  while (c.pieceCount() < pieces) {
    float p[3] = {unit(), unit(), unit()};
    if (p[0] * p[0] + p[1] * p[1] + p[2] * p[2] < 0.09f) continue;
    float d[3] = {0.06f * unit(), 0.06f * unit(), 0.06f * unit()};
    for (int k = 0; k < 4; ++k) {
      c.controls.insert(c.controls.end(), {p[0], p[1], p[2], 0.006f - 0.0015f * float(k)});
      for (int i = 0; i < 3; ++i) {
        p[i] += d[i];
        d[i] += 0.02f * unit();
      }
    }
  }
  return c;
}

void addCurves(scene::Scene& scene, const CurveSet& curves, const scene::NetworkPtr& material) {
  scene::Primitive p;
  scene::Curves shape;
  shape.cubic = true;
  shape.verticesPerCurve.assign(curves.pieceCount(), 4);
  p.shape = std::move(shape);
  std::vector<float> points, widths;
  for (size_t i = 0; i < curves.controls.size(); i += 4) {
    points.insert(points.end(), &curves.controls[i], &curves.controls[i] + 3);
    widths.push_back(2 * curves.controls[i + 3]);
  }
  for (scene::Parameter v :
       {numbers("P", scene::ValueType::Point, points), numbers("width", scene::ValueType::Float, widths)}) {
    v.storage = scene::StorageClass::Vertex;
    p.primvars.set(std::move(v));
  }
  auto attributes = std::make_shared<scene::Attributes>();
  attributes->bxdf = material;
  p.attributes = attributes;
  scene.add(std::move(p));
}

scene::Scene emptyScene(int width, int height) {
  scene::Scene s;
  s.resolution = {width, height};
  s.integrator = node("Integrator", "PxrPathTracer", "integrator",
                      "maxIndirectBounces=4; rouletteThreshold=0; clampLuminance=1e30; allowCaustics=1");
  scene::Camera camera;
  camera.projection = node("Projection", "PxrPerspective", "camera", "fov=75");
  s.cameras.push_back(camera);
  scene::Light light;
  light.node = node("Light", "PxrRectLight", "light", "intensity=8");
  // the unit square of xy, seen from below: 0.6 wide, 0.45 above the camera, a little in front of it
  light.toWorld = scene::Transform::fixed(scene::Matrix(0.6, 0, 0, 0, 0, 0, 0.6, 0, 0, -1, 0, 0, 0, 0.45, 0.1, 1));
  light.attributes = std::make_shared<scene::Attributes>();
  s.add(std::move(light));
  scene::Display d;
  d.file = "bench.exr";
  d.driver = "openexr";
  for (const char* name : {"Ci", "a", "z", "P", "Nn", "albedo", "directDiffuse", "indirectDiffuse", "directSpecular",
                           "indirectSpecular"}) {
    scene::DisplayChannel c;
    c.name = name;
    c.type = std::string(name) == "a" || std::string(name) == "z" ? scene::ValueType::Float : scene::ValueType::Color;
    s.channels.push_back(c);
    d.mode += (d.mode.empty() ? "" : ",") + c.name;
  }
  s.displays.push_back(d);
  return s;
}

}  // namespace kinora::bench
