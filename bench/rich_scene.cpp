#include "rich_scene.h"

#include <OpenImageIO/imagebuf.h>
#include <OpenImageIO/imagebufalgo.h>

#include <array>
#include <cmath>
#include <cstdarg>
#include <cstdio>
#include <fstream>
#include <functional>
#include <random>
#include <stdexcept>

namespace kinora::bench {

namespace {

using scene::Matrix;

constexpr int kMaterials = 40, kPrototypes = 8, kWalls = 4, kTurning = 14, kDeforming = 2, kGlasses = 6;
constexpr int kPlacedOnce = kMaterials - kPrototypes - kWalls - kTurning - kDeforming;

// Text of a RIB file, put together by printf's rules.
class Text {
 public:
  __attribute__((format(printf, 2, 3))) void put(const char* format, ...) {
    char part[1024];
    va_list values;
    va_start(values, format);
    const int n = std::vsnprintf(part, sizeof part, format, values);
    va_end(values);
    if (n < 0 || size_t(n) >= sizeof part) throw std::runtime_error("a line of a scene is too long");
    text_.append(part, size_t(n));
  }
  template <class T>
  void list(const char* format, const std::vector<T>& values) {
    text_ += '[';
    for (const T v : values) put(format, v);
    text_ += "]\n";
  }
  void write(const std::string& file) const {
    std::ofstream out(file, std::ios::binary);
    out << text_;
    out.close();
    if (!out) throw std::runtime_error("'" + file + "' cannot be written");
  }

 private:
  std::string text_;
};

class Random {
 public:
  explicit Random(uint32_t seed) : bits_(seed) {}
  double operator()(double from, double to) { return from + (to - from) * (bits_() / 4294967296.0); }

 private:
  std::mt19937 bits_;
};

// A grid of points over the unit square, as texture coordinates; every quad two triangles. A grid that closes to a
// sphere has points twice along its seam and at its poles, where triangles without area are left out.
RichMesh gridOf(int across, int down, const std::function<std::array<double, 3>(double, double)>& place) {
  RichMesh m;
  const auto points = [&](std::vector<float>& out) {
    for (int j = 0; j <= down; ++j)
      for (int i = 0; i <= across; ++i)
        for (const double x : place(double(i) / across, double(j) / down)) out.push_back(float(x));
  };
  points(m.mesh.points);
  for (int j = 0; j <= down; ++j)
    for (int i = 0; i <= across; ++i) {
      m.st.push_back(float(i) / float(across));
      m.st.push_back(float(j) / float(down));
    }
  const auto apart = [&](int a, int b) {
    const float *p = &m.mesh.points[3 * size_t(a)], *q = &m.mesh.points[3 * size_t(b)];
    return std::abs(p[0] - q[0]) + std::abs(p[1] - q[1]) + std::abs(p[2] - q[2]) > 1e-5f;
  };
  const auto triangle = [&](int a, int b, int c) {
    if (apart(a, b) && apart(b, c) && apart(c, a)) m.mesh.vertices.insert(m.mesh.vertices.end(), {a, b, c});
  };
  for (int j = 0; j < down; ++j)
    for (int i = 0; i < across; ++i) {
      const int a = j * (across + 1) + i, b = a + 1, c = a + across + 2, d = a + across + 1;
      triangle(a, b, c);
      triangle(a, c, d);
    }
  return m;
}

// Radius 1 or so, with bumps of its own; `roughness` 0 is a sphere. Turned so that normals point outwards.
std::array<double, 3> onRock(double s, double t, double roughness, double phase) {
  const double phi = 2 * M_PI * s, theta = M_PI * t;
  const double p[3] = {std::sin(theta) * std::cos(phi), std::cos(theta), std::sin(theta) * std::sin(phi)};
  double r = 1, f = 2.3, gain = roughness;
  for (int k = 0; k < 4; ++k) {
    r += gain * std::sin(f * p[0] + phase) * std::sin(f * p[1] + 1.7 * phase) * std::sin(f * p[2] + 0.6);
    f *= 2.1;
    gain *= 0.5;
  }
  return {r * p[0], r * p[1], r * p[2]};
}

RichMesh rock(int size, double roughness, double phase) {
  return gridOf(2 * size, size, [=](double s, double t) { return onRock(s, t, roughness, phase); });
}

// Area-weighted means of the facets' normals, unit.
std::vector<float> normalsOf(const TriangleMesh& m, const std::vector<float>& points) {
  std::vector<float> n(points.size(), 0.f);
  for (size_t t = 0; t < m.vertices.size(); t += 3) {
    const float* p[3];
    for (int k = 0; k < 3; ++k) p[k] = &points[3 * size_t(m.vertices[t + size_t(k)])];
    for (int c = 0; c < 3; ++c) {
      const int a = (c + 1) % 3, b = (c + 2) % 3;
      const float x = (p[1][a] - p[0][a]) * (p[2][b] - p[0][b]) - (p[1][b] - p[0][b]) * (p[2][a] - p[0][a]);
      for (int k = 0; k < 3; ++k) n[3 * size_t(m.vertices[t + size_t(k)]) + size_t(c)] += x;
    }
  }
  for (size_t i = 0; i < n.size(); i += 3) {
    const float l = std::sqrt(n[i] * n[i] + n[i + 1] * n[i + 1] + n[i + 2] * n[i + 2]);
    for (size_t c = 0; c < 3; ++c) n[i + c] = l > 0 ? n[i + c] / l : c == 1;
  }
  return n;
}

void putMesh(Text& text, const RichMesh& m) {
  const auto one = [&](const std::vector<float>& points) {
    text.put("PointsPolygons ");
    text.list("%d ", std::vector<int>(m.mesh.triangleCount(), 3));
    text.list("%d ", m.mesh.vertices);
    text.put("\"vertex point P\" ");
    text.list("%.7g ", points);
    text.put("\"vertex normal N\" ");
    text.list("%.4g ", normalsOf(m.mesh, points));
    text.put("\"vertex float[2] st\" ");
    text.list("%.6g ", m.st);
  };
  if (m.later.empty()) return one(m.mesh.points);
  text.put("MotionBegin [0 1]\n");
  one(m.mesh.points);
  one(m.later);
  text.put("MotionEnd\n");
}

void putTransform(Text& text, const scene::Transform& t) {
  if (t.matrices.size() > 1) text.put("MotionBegin [0 1]\n");
  for (const Matrix& m : t.matrices) {
    text.put("ConcatTransform [");
    for (int i = 0; i < 4; ++i)
      for (int j = 0; j < 4; ++j) text.put("%.9g ", m[i][j]);
    text.put("]\n");
  }
  if (t.matrices.size() > 1) text.put("MotionEnd\n");
}

Matrix placed(double scale, double turn, double x, double y, double z) {
  const double c = std::cos(turn), s = std::sin(turn);
  return Matrix(scale * c, 0, -scale * s, 0, 0, scale, 0, 0, scale * s, 0, scale * c, 0, x, y, z, 1);
}

// A tiled mip-mapped picture whose pixels are told by a function.
std::string writePicture(const std::string& file, int size, const std::function<std::array<float, 3>(int, int)>& at) {
  OIIO::ImageBuf picture(OIIO::ImageSpec(size, size, 3, OIIO::TypeDesc::UINT8));
  for (int y = 0; y < size; ++y)
    for (int x = 0; x < size; ++x) picture.setpixel(x, y, at(x, y).data());
  if (!OIIO::ImageBufAlgo::make_texture(OIIO::ImageBufAlgo::MakeTxTexture, picture, file, OIIO::ImageSpec()))
    throw std::runtime_error("'" + file + "' cannot be written");
  return file;
}

float grain(int x, int y, int k) {
  const uint32_t h = (uint32_t(x) * 73856093u ^ uint32_t(y) * 19349663u ^ uint32_t(k) * 83492791u) * 2654435761u;
  return float(h >> 8) / 16777216.f;
}

// Five pictures a material: colour, roughness, reflection, coat, and normals (or heights).
std::array<std::string, 5> writeMaterialPictures(const std::string& folder, int k, int size) {
  const std::string start = folder + "/m" + std::to_string(k) + "_";
  const float tint[3] = {0.25f + 0.5f * grain(k, 0, 1), 0.25f + 0.5f * grain(k, 1, 1), 0.25f + 0.5f * grain(k, 2, 1)};
  const auto waves = [=](int x, int y) {
    const float f = 6.2831853f * float(1 + k % 5) / float(size);
    return 0.5f + 0.25f * std::sin(f * float(x)) + 0.25f * std::sin(f * float(y) + float(k));
  };
  return {writePicture(start + "colour.tx", size,
                       [&](int x, int y) {
                         const float v = 0.5f + 0.3f * waves(x, y) + 0.2f * grain(x, y, k);
                         return std::array{tint[0] * v, tint[1] * v, tint[2] * v};
                       }),
          writePicture(start + "roughness.tx", size,
                       [&](int x, int y) {
                         const float v = 0.15f + 0.5f * waves(y, x) + 0.1f * grain(x, y, k + 50);
                         return std::array{v, v, v};
                       }),
          writePicture(start + "reflection.tx", size,
                       [&](int x, int y) {
                         const float v = 0.04f + 0.3f * float((x * 8 / size + y * 8 / size + k) % 2);
                         return std::array{v, v * 0.9f, v * 0.8f};
                       }),
          writePicture(start + "coat.tx", size,
                       [&](int x, int y) {
                         const float v = 0.04f * float(grain(x * 16 / size, y * 16 / size, k) > 0.5f);
                         return std::array{v, v, v};
                       }),
          writePicture(start + "normal.tx", size, [&](int x, int y) {
            return std::array{0.42f + 0.16f * waves(2 * x, y), 0.42f + 0.16f * waves(x, 2 * y), 0.97f};
          })};
}

// Four structures of networks: textures alone; roughness remapped; the colour graded; heights instead of normals.
void putMaterial(Text& text, int k, const std::array<std::string, 5>& pictures) {
  static const char* const kNames[4] = {"colour", "roughness", "reflection", "coat"};
  for (int i = 0; i < 4; ++i)
    text.put("Pattern \"PxrTexture\" \"%s\" \"string filename\" [\"%s\"]\n", kNames[i], pictures[size_t(i)].c_str());
  if (k % 4 == 3)
    text.put("Pattern \"PxrBump\" \"normal\" \"string filename\" [\"%s\"] \"float scale\" [0.02]\n",
             pictures[4].c_str());
  else
    text.put("Pattern \"PxrNormalMap\" \"normal\" \"string filename\" [\"%s\"]\n", pictures[4].c_str());
  const char *roughness = "roughness:resultR", *colour = "colour:resultRGB";
  if (k % 4 == 1) {
    text.put(
        "Pattern \"PxrRemap\" \"smoother\" \"reference color inputRGB\" [\"roughness:resultRGB\"] "
        "\"float outputMin\" [0.1] \"float outputMax\" [%.3g]\n",
        0.4 + 0.01 * k);
    roughness = "smoother:resultR";
  }
  if (k % 4 == 2) {
    text.put(
        "Pattern \"PxrMix\" \"graded\" \"reference color color1\" [\"colour:resultRGB\"] \"color color2\" "
        "[0.6 0.5 0.3] \"float mix\" [%.3g]\n",
        0.01 * k);
    colour = "graded:resultRGB";
  }
  text.put(
      "Bxdf \"PxrSurface\" \"material%d\" \"reference color diffuseColor\" [\"%s\"] "
      "\"reference float specularRoughness\" [\"%s\"] \"int specularModelType\" [1] ",
      k, colour, roughness);
  text.put(
      "\"reference color specularFaceColor\" [\"reflection:resultRGB\"] \"color specularEdgeColor\" [1 1 1] "
      "\"reference color clearcoatFaceColor\" [\"coat:resultRGB\"] \"float clearcoatRoughness\" [0.1] "
      "\"reference normal bumpNormal\" [\"normal:resultN\"]\n");
}

void putLight(Text& text, const char* plugin, int k, const Matrix& at, double intensity) {
  text.put("AttributeBegin\n");
  putTransform(text, scene::Transform::fixed(at));
  text.put(
      "Light \"%s\" \"light%d\" \"float intensity\" [%.6g] \"color lightColor\" [%.3g %.3g %.3g]\nAttributeEnd\n",
      plugin, k, intensity, 0.6 + 0.4 * grain(k, 3, 0), 0.8, 0.6 + 0.4 * grain(k, 4, 0));
}

// A sky with a bright spot, latitude and longitude.
std::string writeSky(const std::string& folder, int size) {
  OIIO::ImageBuf sky(OIIO::ImageSpec(2 * size, size, 3, OIIO::TypeDesc::HALF));
  for (int y = 0; y < size; ++y)
    for (int x = 0; x < 2 * size; ++x) {
      const float up = 1 - 2 * (float(y) + 0.5f) / float(size), dx = float(x) / float(size) - 0.6f, dy = up - 0.6f;
      const float spot = 12 * std::exp(-60 * (dx * dx + dy * dy)), base = up > 0 ? 0.35f + 0.3f * up : 0.12f;
      const float rgb[3] = {base * 0.8f + spot, base * 0.9f + 0.9f * spot, base + 0.7f * spot};
      sky.setpixel(x, y, rgb);
    }
  const std::string file = folder + "/sky.exr";
  if (!sky.write(file)) throw std::runtime_error("'" + file + "' cannot be written");
  return file;
}

// What stands before the world: camera, integrator and the core's channels.
void putFrame(Text& text, const char* name, int width, int height, int bounces) {
  text.put("##RenderMan RIB-Structure 1.1\n# Written by kinora-bench: a scene to be measured.\n");
  text.put("Hider \"raytrace\" \"int maxsamples\" [64] \"int minsamples\" [64]\n");
  text.put("Integrator \"PxrPathTracer\" \"integrator\" \"int maxIndirectBounces\" [%d]\n", bounces);
  std::string mode;
  for (const char* channel :
       {"color Ci", "float a", "float z", "color P", "color Nn", "color albedo", "color directDiffuse",
        "color indirectDiffuse", "color directSpecular", "color indirectSpecular"}) {
    text.put("DisplayChannel \"%s\"\n", channel);
    mode += (mode.empty() ? "" : ",") + std::string(channel).substr(std::string(channel).find(' ') + 1);
  }
  text.put("Display \"%s.exr\" \"openexr\" \"%s\"\n", name, mode.c_str());
  text.put("Format %d %d 1\nShutter 0 1\nProjection \"perspective\" \"fov\" [70]\n", width, height);
}

}  // namespace

RichScene writeRichScene(const std::string& folder, bool quick) {
  RichScene scene;
  scene.file = folder + "/rich.rib";
  Random random(11);
  const int rocks = quick ? 8 : 32, instances = quick ? 20 : 300;

  // meshes: the walls, then those placed once, those that turn, those that deform, and the prototypes, each with the
  // material of its number; behind them the glass
  std::vector<RichMesh>& meshes = scene.meshes;
  const int ground = quick ? 12 : 150, wall = quick ? 6 : 60;
  const auto hill = [](double x, double z) {
    return 0.12 * std::sin(1.3 * x) * std::sin(1.1 * z + 0.4) + 0.03 * std::sin(5.1 * x + 0.3) * std::sin(4.7 * z);
  };
  meshes.push_back(gridOf(ground, ground, [&](double s, double t) {
    const double x = 16 * s - 8, z = 20 * (1 - t) - 6;
    return std::array{x, hill(x, z) - 1.2, z};
  }));
  const auto bumps = [](double a, double b) { return 0.08 * std::sin(3 * a) * std::sin(4 * b); };
  meshes.push_back(gridOf(wall, wall, [&](double s, double t) {
    return std::array{-7.5 + bumps(9 * s, 3 * t), 3.5 - 5 * t, 18 * s - 5};
  }));
  meshes.push_back(gridOf(wall, wall, [&](double s, double t) {
    return std::array{7.5 + bumps(9 * s, 3 * t), 5 * t - 1.5, 18 * s - 5};
  }));
  meshes.push_back(gridOf(wall, wall, [&](double s, double t) {
    return std::array{16 * s - 8, 3.5 - 5 * t, 13 + bumps(9 * s, 3 * t)};
  }));
  for (int k = kWalls; k < kMaterials; ++k) meshes.push_back(rock(rocks, 0.12 + 0.01 * (k % 9), 0.7 * k));
  const int firstPlaced = kWalls, firstTurning = firstPlaced + kPlacedOnce, firstDeforming = firstTurning + kTurning,
            firstPrototype = firstDeforming + kDeforming;
  for (int k = firstDeforming; k < firstPrototype; ++k) {
    const RichMesh end = rock(rocks, 0.25 + 0.01 * (k % 9), 0.7 * k + 0.2);
    meshes[size_t(k)].mesh = rock(rocks, 0.02, 0.7 * k).mesh;  // a sphere's triangles serve both ends
    meshes[size_t(k)].later = end.mesh.points;
  }
  for (int k = 0; k < kGlasses; ++k) {
    meshes.push_back(rock(rocks, k % 2 ? 0.05 : 0, k));
    meshes.back().isGlass = true;
  }

  const auto add = [&](size_t mesh, bool isInstance, const std::vector<Matrix>& keys) {
    scene::Transform t;
    t.matrices = keys;
    if (keys.size() > 1) t.times = {0, 1};
    scene.placements.push_back({mesh, isInstance, t});
  };
  const auto somewhere = [&](double scale, double lift) {
    const double x = random(-6, 6), z = random(2.5, 11.5);
    return placed(scale, random(0, 6), x, hill(x, z) - 1.2 + lift * scale, z);
  };
  for (int k = 0; k < kWalls; ++k) add(size_t(k), false, {Matrix()});
  for (int k = firstPlaced; k < firstTurning; ++k) add(size_t(k), false, {somewhere(random(0.3, 0.7), 0.6)});
  for (int k = firstTurning; k < firstDeforming; ++k) {
    const double scale = random(0.2, 0.5), turn = random(0, 6), x = random(-4, 4), y = random(-0.4, 1.6),
                 z = random(3, 10);
    add(size_t(k), false,
        {placed(scale, turn, x, y, z), placed(scale, turn + 0.3, x + random(-0.3, 0.3), y + 0.1, z)});
  }
  for (int k = firstDeforming; k < firstPrototype; ++k) add(size_t(k), false, {somewhere(0.6, 0.9)});
  for (int k = 0; k < instances; ++k)
    add(size_t(firstPrototype + k % kPrototypes), true, {somewhere(random(0.08, 0.35), 0.5)});
  for (int k = 0; k < kGlasses; ++k)
    add(size_t(kMaterials + k), false, {placed(0.45, 0.3 * k, -2.5 + k, -0.6 + 0.25 * (k % 3), 3 + 0.4 * (k % 2))});

  Text text;
  putFrame(text, "rich", quick ? 32 : 240, quick ? 20 : 135, 4);
  text.put("WorldBegin\nAttributeBegin\n");
  // the dome's own up is z: it becomes y
  text.put("ConcatTransform [0 0 -1 0  -1 0 0 0  0 1 0 0  0 0 0 1]\n");
  text.put(
      "Light \"PxrDomeLight\" \"sky\" \"string lightColorMap\" [\"%s\"] \"float intensity\" [0.6]\nAttributeEnd\n",
      writeSky(folder, quick ? 16 : 128).c_str());
  for (int k = 0; k < 20; ++k) {
    const double x = random(-6, 6), y = random(1.5, 3), z = random(1, 12), s = random(0.2, 0.5);
    // lights with a face shine along their -z: turned to shine down
    const Matrix down(s, 0, 0, 0, 0, 0, s, 0, 0, -s, 0, 0, x, y, z, 1);
    if (k < 8)
      putLight(text, "PxrSphereLight", k, Matrix(s, 0, 0, 0, 0, s, 0, 0, 0, 0, s, 0, x, y, z, 1), random(1, 4));
    else if (k < 14)
      putLight(text, "PxrRectLight", k, down, random(3, 9));
    else if (k < 18)
      putLight(text, "PxrDiskLight", k, down, random(3, 9));
    else
      putLight(text, "PxrDistantLight", k, Matrix(1, 0, 0, 0, 0, .6, .8, 0, 0, -.8, .6, 0, 0, 0, 0, 1), 2000);
  }
  std::vector<std::array<std::string, 5>> pictures;
  for (int k = 0; k < kMaterials; ++k) pictures.push_back(writeMaterialPictures(folder, k, quick ? 16 : 256));
  for (int k = firstPrototype; k < kMaterials; ++k) {
    text.put("ObjectBegin \"prototype%d\"\n", k);
    putMaterial(text, k, pictures[size_t(k)]);
    putMesh(text, meshes[size_t(k)]);
    text.put("ObjectEnd\n");
  }
  for (const RichPlacement& p : scene.placements) {
    text.put("AttributeBegin\n");
    if (!p.isInstance && meshes[p.mesh].isGlass)
      text.put(
          "Bxdf \"PxrSurface\" \"glass%d\" \"float diffuseGain\" [0] \"float refractionGain\" [1] "
          "\"float reflectionGain\" [1] \"float glassRoughness\" [%.3g] \"color extinction\" [0.3 0.1 %.3g]\n",
          int(p.mesh), p.mesh % 3 ? 0. : 0.2, 0.1 * double(p.mesh % 4));
    else if (!p.isInstance)
      putMaterial(text, int(p.mesh), pictures[p.mesh]);
    putTransform(text, p.toWorld);
    if (p.isInstance)
      text.put("ObjectInstance \"prototype%d\"\n", int(p.mesh));
    else
      putMesh(text, meshes[p.mesh]);
    text.put("AttributeEnd\n");
  }
  text.put("WorldEnd\n");
  text.write(scene.file);
  return scene;
}

std::string writeNestedGlasses(const std::string& folder, bool quick) {
  Text text;
  putFrame(text, "glass", quick ? 32 : 192, quick ? 20 : 108, 24);
  text.put("WorldBegin\n");
  text.put("Light \"PxrDomeLight\" \"sky\" \"float intensity\" [0.4]\n");
  putLight(text, "PxrRectLight", 0, Matrix(2, 0, 0, 0, 0, 0, 2, 0, 0, -2, 0, 0, 1, 4, 2, 1), 6);
  text.put(
      "AttributeBegin\nPattern \"PxrChecker\" \"tiles\"\n"
      "Bxdf \"PxrDiffuse\" \"floor\" \"reference color diffuseColor\" [\"tiles:resultRGB\"]\n"
      "Polygon \"vertex point P\" [-9 -2 -3  9 -2 -3  9 -2 15  -9 -2 15]\nAttributeEnd\n");
  // the inner ones win over what they stand in
  for (int k = 0; k < 10; ++k) {
    text.put("AttributeBegin\nAttribute \"trace\" \"int intersectpriority\" [%d]\n", k + 1);
    text.put(
        "Bxdf \"PxrSurface\" \"glass%d\" \"float diffuseGain\" [0] \"float refractionGain\" [1] "
        "\"float reflectionGain\" [1] \"float glassRoughness\" [0] \"float glassIor\" [%.3g] "
        "\"color extinction\" [%.3g 0.02 %.3g]\n",
        k, k % 2 ? 1.5 : 1.33, 0.02 * (k % 3), 0.02 * (k % 4));
    text.put("Translate %.3g 0 4\n", 0.02 * k);
    putMesh(text, [&] {
      RichMesh m = rock(quick ? 8 : 48, 0, 0);
      for (float& x : m.mesh.points) x *= 1.9f - 0.17f * float(k);
      return m;
    }());
    text.put("AttributeEnd\n");
  }
  text.put("WorldEnd\n");
  text.write(folder + "/glass.rib");
  return folder + "/glass.rib";
}

}  // namespace kinora::bench
