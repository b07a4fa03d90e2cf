// One million triangles in 200 objects of 200 materials under a dome of 4k: from update() begun to the first ray
// group started, after an edit of each kind, by the clock and in CPU time of the whole process.
#include "edits.h"

#include <atomic>
#include <cmath>
#include <memory>
#include <random>
#include <stdexcept>

#include "folder.h"
#include "image/read_write.h"
#include "plugin/registry.h"
#include "render/renderer.h"
#include "scenes.h"
#include "shade/ray_listener.h"

namespace kinora::bench {

namespace {

// Notes when the first rays of a render are traced, and has it stopped then.
class FirstGroup final : public shade::RayListener {
 public:
  explicit FirstGroup(std::atomic<bool>& stop) : stop_(stop) {}
  void begin() {
    isSeen_ = false;
    stop_ = false;
    wall_ = wallSeconds();
    cpu_ = processSeconds();
  }
  void closest(RayKind, uint32_t, const Rays&, uint32_t, const uint32_t*) override {
    if (isSeen_.exchange(true)) return;
    wall_ = wallSeconds() - wall_;
    cpu_ = processSeconds() - cpu_;
    stop_ = true;
  }
  void shadow(uint32_t, const ShadowRays&) override {}
  bool isSeen() const { return isSeen_; }
  double wall() const { return wall_; }
  double cpu() const { return cpu_; }

 private:
  std::atomic<bool>& stop_;
  std::atomic<bool> isSeen_{false};
  double wall_ = 0, cpu_ = 0;
};

// A sky with a bright spot; "" when it cannot be written.
std::string writeSky(const std::string& folder, int width) {
  image::Image sky({0, 0, width, width / 2},
                   {{"R", image::StoredType::Half}, {"G", image::StoredType::Half}, {"B", image::StoredType::Half}});
  for (int y = 0; y < width / 2; ++y)
    for (int x = 0; x < width; ++x) {
      const float up = 1 - 2 * float(y) / float(width), dx = float(x) / float(width) - 0.3f, dy = up - 0.6f;
      const float sun = dx * dx + dy * dy < 1e-4f ? 500.f : 0.f;
      float* p = &sky.pixels[3 * (size_t(y) * size_t(width) + size_t(x))];
      p[0] = 0.3f + 0.2f * up + sun;
      p[1] = 0.4f + 0.3f * up + sun;
      p[2] = 0.5f + 0.5f * up + sun;
    }
  const std::string file = folder + "/sky.exr";
  return image::write(file, sky).ok() ? file : "";
}

scene::Parameter vertexData(const char* name, scene::ValueType type, std::vector<float> floats) {
  scene::Parameter p;
  p.name = name;
  p.storage = scene::StorageClass::Vertex;
  p.type = type;
  p.floats = std::move(floats);
  return p;
}

// A dented ball of 2 n^2 triangles, with smooth normals and st.
scene::Primitive pebble(int n, uint32_t seed) {
  std::mt19937 random(seed);
  const float dent = 0.05f + 0.1f * float(random() >> 8) * 0x1p-24f;
  std::vector<float> P, N, st;
  for (int j = 0; j <= n; ++j)
    for (int i = 0; i <= n; ++i) {
      const float u = float(i) / float(n), v = float(j) / float(n), a = 6.2831853f * u, b = 3.1415926f * v;
      const float d[3] = {std::sin(b) * std::cos(a), std::cos(b), std::sin(b) * std::sin(a)};
      const float r = 1 + dent * std::sin(5 * a) * std::sin(4 * b);
      for (const float x : d) P.push_back(r * x), N.push_back(x);
      st.insert(st.end(), {u, v});
    }
  scene::PolygonMesh mesh;
  mesh.verticesPerLoop.assign(size_t(n) * size_t(n), 4);
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      const int at = j * (n + 1) + i;
      mesh.vertices.insert(mesh.vertices.end(), {at, at + 1, at + n + 2, at + n + 1});
    }
  scene::Primitive p;
  p.shape = std::move(mesh);
  p.primvars.set(vertexData("P", scene::ValueType::Point, std::move(P)));
  p.primvars.set(vertexData("N", scene::ValueType::Normal, std::move(N)));
  scene::Parameter coordinates = vertexData("st", scene::ValueType::Float, std::move(st));
  coordinates.isArray = true;
  coordinates.arrayLength = 2;
  p.primvars.set(std::move(coordinates));
  return p;
}

scene::NetworkPtr withColor(const scene::NetworkPtr& network, float red) {
  auto n = std::make_shared<scene::Network>(*network);
  auto terminal = std::make_shared<scene::Node>(*n->terminal);
  for (const scene::Parameter& p : parameters("specularEdgeColor=" + std::to_string(red) + " 0.5 0.4"))
    terminal->params.set(p);
  n->terminal = std::move(terminal);
  return n;
}

scene::Scene meadow(const std::string& folder, bool isQuick) {
  const int side = isQuick ? 4 : 20, count = isQuick ? 12 : 200, n = isQuick ? 6 : 50;
  scene::Scene s = emptyScene(isQuick ? 32 : 960, isQuick ? 24 : 540);
  scene::Light dome;
  auto sky = std::make_shared<scene::Node>(*node("Light", "PxrDomeLight", "dome", "intensity=0.5"));
  scene::Parameter map;
  map.name = "lightColorMap";
  map.type = scene::ValueType::String;
  map.strings = {writeSky(folder, isQuick ? 64 : 4096)};
  sky->params.set(std::move(map));
  dome.node = sky;
  s.add(std::move(dome));
  const scene::NetworkPtr plain = texturedSurface(writePictures(folder));
  for (int k = 0; k < count; ++k) {
    scene::Primitive p = pebble(n, uint32_t(k));
    auto attributes = std::make_shared<scene::Attributes>();
    attributes->bxdf = withColor(plain, float(k) / float(count));
    p.attributes = std::move(attributes);
    p.toWorld = scene::Transform::fixed(scene::Matrix().setTranslation(
        Imath::V3d(2.5 * (k % side - side / 2), -2.0 - 0.1 * (k % 3), 4 + 2.5 * (k / side))));
    s.add(std::move(p));
  }
  return s;
}

scene::Transform moved(const scene::Transform& t, double by) {
  return scene::concat(t, scene::Transform::fixed(scene::Matrix().setTranslation(Imath::V3d(by, 0, by))));
}

struct Kind {
  const char *name, *meaning;
  void (*edit)(scene::Scene&, double by);
};
const Kind kKinds[] = {
    {"camera", "the camera moved",
     [](scene::Scene& s, double by) {
       scene::Camera c = s.cameras[0];
       c.worldToCamera = moved(c.worldToCamera, by);
       s.setCamera(0, c);
     }},
    {"light", "the small light brighter",
     [](scene::Scene& s, double by) {
       scene::Light l = s.lights[0];
       auto n = std::make_shared<scene::Node>(*l.node);
       for (const scene::Parameter& p : parameters("intensity=" + std::to_string(8 + by))) n->params.set(p);
       l.node = std::move(n);
       s.setLight(l.id, l);
     }},
    {"dome", "the dome turned",
     [](scene::Scene& s, double by) {
       scene::Light l = s.lights[1];
       l.toWorld = scene::Transform::fixed(scene::Matrix().setAxisAngle(Imath::V3d(0, 1, 0), by));
       s.setLight(l.id, l);
     }},
    {"material", "one material's colour",
     [](scene::Scene& s, double by) {
       const scene::PrimitivePtr& p = s.primitives[s.primitives.size() / 2];
       auto a = std::make_shared<scene::Attributes>(*p->attributes);
       a->bxdf = withColor(a->bxdf, float(by));
       s.setPrimitiveAttributes(p->id, std::move(a));
     }},
    {"object", "one object moved",
     [](scene::Scene& s, double by) {
       const scene::PrimitivePtr& p = s.primitives[s.primitives.size() / 2];
       s.setPrimitiveTransform(p->id, moved(p->toWorld, by));
     }},
};

}  // namespace

void measureEdits(const Options& options, Figures& figures) {
  const Folder folder;
  Registry registry;
  Diagnostics diagnostics([](const std::string& line, Severity severity) {
    if (severity == Severity::Error) std::fprintf(stderr, "%s\n", line.c_str());
  });
  std::atomic<bool> stop{false};
  FirstGroup first(stop);
  render::Settings settings;
  settings.rayListener = &first;
  settings.stop = &stop;
  const auto sinceBegun = [&](render::Renderer& r, bool isBuilt) {
    if (isBuilt) r.renderFilm();
    if (!isBuilt || !first.isSeen()) throw std::runtime_error("no ray was traced after an edit");
  };
  std::vector<double> load;
  render::Renderer r(registry, diagnostics, settings);
  {
    scene::Scene scene = meadow(folder.path(), options.quick);
    first.begin();
    sinceBegun(r, r.load(std::move(scene)));
    load.push_back(first.wall() * 1e3);
  }
  const uint64_t triangles = r.statistics().triangles;
  std::vector<std::vector<double>> wall(std::size(kKinds)), cpu(std::size(kKinds));
  for (int k = 0; k < options.repeat; ++k)
    for (size_t i = 0; i < std::size(kKinds); ++i) {
      kKinds[i].edit(r.scene(), 0.01 * (k + 1));
      stop = false;
      first.begin();
      sinceBegun(r, r.update());
      wall[i].push_back(first.wall() * 1e3);
      cpu[i].push_back(first.cpu() * 1e3);
    }
  std::printf("%llu triangles, %llu materials\n", static_cast<unsigned long long>(triangles),
              static_cast<unsigned long long>(r.statistics().materials));
  figures.add("edit_load_ms", load, "from the load begun to the first ray group, for comparison");
  for (size_t i = 0; i < std::size(kKinds); ++i) {
    const std::string name = std::string("edit_") + kKinds[i].name;
    figures.add(name + "_ms", wall[i],
                std::string(kKinds[i].meaning) + ": from update() begun to the first ray group");
    figures.add(name + "_cpu_ms", cpu[i], "the same in CPU time of all threads");
  }
}

}  // namespace kinora::bench
