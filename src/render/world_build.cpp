#include "render/world_build.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <map>
#include <set>
#include <utility>

#include "base/memory.h"
#include "base/text.h"
#include "geometry/tessellate.h"
#include "image/colors.h"
#include "render/camera_attributes.h"
#include "render/camera_parameters.h"
#include "render/filters.h"
#include "render/mesh_light.h"
#include "render/shutter.h"
#include "render/stand_ins.h"
#include "sampling/sample_table.h"
#include "scene/bytes.h"
#include "scene/uniform_keys.h"
#include "shade/bxdf_stand_ins.h"
#include "shade/shader_scene.h"
#include "simd/dispatch.h"
#include "texture/texture_system.h"
#include "volume/volume_system.h"

namespace kinora::render {

namespace {

constexpr double kPixelsPerEdge = 2.0;  // micropolygon edge at dice:micropolygonlength 1; normals are exact anyway

// Whose create() this thread is in: messages and images that a plug-in asks for there are about that node.
thread_local const scene::Node* nodeBeingMade = nullptr;
// No exception crosses a plug-in: a size that was refused on its behalf waits here until its create() is over.
thread_local std::exception_ptr refusedSize;

void hostWarn(void* self, const char* code, const char* what, const char* done) {
  static_cast<Diagnostics*>(static_cast<void**>(self)[0])
      ->warning(code, nodeBeingMade ? nodeBeingMade->pos : SourcePos{}, what, done);
}
const HostImage* hostImage(void* self, const char* file, int linearize) {
  TextureRequest request;
  if (nodeBeingMade) {
    request.pos = nodeBeingMade->pos;
    request.object = nodeBeingMade->plugin + " '" + nodeBeingMade->handle + "'";
  }
  try {
    return static_cast<TextureSystem*>(static_cast<void**>(self)[1])->image(file, linearize, request);
  } catch (const std::bad_alloc&) {
    refusedSize = std::current_exception();
    return nullptr;
  }
}

bool finite(const scene::Matrix& m) {
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j)
      if (!std::isfinite(m[i][j])) return false;
  return true;
}

// Brings a deforming mesh to keys that are uniform over the shutter, as Embree wants them; one key where nothing
// moves.
void uniformKeys(geometry::Mesh& mesh, double open, double close) {
  if (mesh.keyCount() < 2) return;
  const auto at = [&](double time, const float* data, size_t stride, std::vector<float>& out) {
    const auto& t = mesh.times;
    size_t k = 0;
    while (k + 2 < t.size() && time > t[k + 1]) ++k;
    const double f = t[k + 1] > t[k] ? std::clamp((time - t[k]) / (t[k + 1] - t[k]), 0.0, 1.0) : 0.0;
    for (size_t i = 0; i < stride; ++i)
      out.push_back(float((1 - f) * double(data[k * stride + i]) + f * double(data[(k + 1) * stride + i])));
  };
  const int keys = scene::uniformKeyCount(mesh.times, open, close, 65);
  const auto resample = [&](const float* data, size_t stride) {
    std::vector<float> out;
    out.reserve(stride * size_t(keys));
    for (int k = 0; k < keys; ++k)
      at(keys == 1 ? 0.5 * (open + close) : open + (close - open) * k / (keys - 1), data, stride, out);
    return out;
  };
  const auto bring = [&](auto& elements) {
    if (elements.empty()) return;
    constexpr size_t kFloats = sizeof(elements[0]) / sizeof(float);
    const std::vector<float> out = resample(&elements[0].x, size_t(mesh.vertexCount) * kFloats);
    elements.resize(out.size() / kFloats);
    std::memcpy(&elements[0].x, out.data(), out.size() * sizeof(float));
  };
  for (geometry::Primvar& v : mesh.primvars)
    if (v.name == "N" && v.rate == geometry::Primvar::Rate::PerVertex &&
        v.data.size() == size_t(mesh.keyCount()) * mesh.vertexCount * 3)
      v.data = resample(v.data.data(), size_t(mesh.vertexCount) * 3);
  bring(mesh.points);
  bring(mesh.spine);
  bring(mesh.spineNormals);
  mesh.times.clear();
  for (int k = 0; k < keys && keys > 1; ++k) mesh.times.push_back(double(k) / (keys - 1));
}

// What of its attributes a mesh is made by.
std::string lookOf(const scene::Attributes& a) {
  std::string out = std::to_string(int(a.orientation)) + (a.reverseOrientation ? 'r' : '-') + std::to_string(a.sides);
  const auto number = [&](float v) { out += ' ' + std::to_string(v); };
  for (const float c : a.textureCoordinates) number(c);
  if (a.displacement) out += " displaced";
  for (const scene::Parameter& p : a.named)
    if (p.name.starts_with("dice:") || p.name.starts_with("polygon:")) {
      out += ' ' + p.name;
      for (const float v : p.floats) number(v);
      for (const int v : p.ints) out += ' ' + std::to_string(v);
      for (const std::string& v : p.strings) out += ' ' + v;
    }
  return out;
}

}  // namespace

bool Instance::create(const Descriptor& plugin, const scene::Node* node, const Placement* placement,
                      const void* extra, const Host& host, Diagnostics& diagnostics) {
  plugin_ = &plugin;
  data_.reset();
  if (!plugin.create) return true;
  const shade::ResolvedParams params(plugin, node, diagnostics);
  CreateInfo info{};
  info.host = &host;
  info.handle = node && !node->handle.empty() ? node->handle.c_str() : plugin.name;
  info.values = params.values();
  info.valueCount = params.count();
  info.placement = placement;
  info.extra = extra;
  ErrorText error{};
  void* made = nullptr;
  nodeBeingMade = node;
  try {
    made = plugin.create(&info, &error);
  } catch (...) {
    // a plug-in that does not use guardedCreate()
    std::snprintf(error.text, sizeof error.text, "exception in create()");
  }
  nodeBeingMade = nullptr;
  if (const std::exception_ptr refused = std::exchange(refusedSize, nullptr)) {
    if (made && plugin.destroy) plugin.destroy(made);
    plugin_ = nullptr;
    std::rethrow_exception(refused);
  }
  if (!made) {
    diagnostics.warning("PLUGIN-CREATE", node ? node->pos : SourcePos{},
                        std::string(plugin.name) + " '" + info.handle +
                            "' cannot be made: " + (error.text[0] ? error.text : "no reason given"),
                        "a fallback is used");
    plugin_ = nullptr;
    return false;
  }
  data_ = std::shared_ptr<void>(made, [destroy = plugin.destroy](void* p) {
    if (destroy) destroy(p);
  });
  Memory::check(MemoryUse::Textures);  // tables over a light's map are the plug-in's own
  return true;
}

WorldBuilder::WorldBuilder(Registry& registry, Diagnostics& diagnostics, const Settings& settings)
    : registry_(registry), diagnostics_(diagnostics), settings_(settings), shaders_(diagnostics, &contents_) {
  width_ = settings.width ? settings.width : bestWidth();
  if (width_ == 16 && !cpuHasAvx512()) width_ = 8;  // sixteen lanes run as two of eight: the same bits
  textures_ = std::make_unique<TextureSystem>(diagnostics, &contents_);
  volumes_ = std::make_unique<VolumeSystem>(diagnostics, settings.volumeReader, &contents_);
  static_assert(sizeof(void*) == 8);
  auto* pointers = new void* [2] { &diagnostics_, textures_.get() };
  host_ = Host{pointers, &hostWarn, &hostImage};
  if (settings.textureCacheBytes) textures_->setCacheLimit(settings.textureCacheBytes);
}

WorldBuilder::~WorldBuilder() { delete[] static_cast<void**>(host_.self); }

bool WorldBuilder::buildCamera(const scene::Scene& scene) {
  scene::Camera camera;
  if (!scene.cameras.empty()) camera = scene.cameras.front();
  CameraState& c = camera_;
  std::array<int, 2> res = scene.resolution;
  if (settings_.resolution[0] > 0) res = settings_.resolution;
  if (res[0] <= 0) res[0] = 640;
  if (res[1] <= 0) res[1] = 480;
  if (scene.frameAspect > 0) {
    // The largest part of the format that has this shape is the picture. Ratios are rounded numbers: what differs by
    // less than 1 % is meant to be the format's own. A resolution of the command line is a format too.
    const std::array<int, 2> asked = res;
    const double pixel = scene.pixelAspect > 0 ? scene.pixelAspect : 1, whole = res[0] * pixel / res[1];
    const double f = scene.frameAspect;
    if (f > whole * 1.01)
      res[1] = std::max(1, int(std::lround(res[0] * pixel / f)));
    else if (f < whole * 0.99)
      res[0] = std::max(1, int(std::lround(res[1] * f / pixel)));
    if (settings_.resolution[0] > 0 && res != asked)
      diagnostics_.warning("RENDER-FRAME-ASPECT", scene.pos,
                           "the scene's FrameAspectRatio is not that of " + std::to_string(asked[0]) + " x " +
                               std::to_string(asked[1]) + " pixels",
                           "the picture is the part of that shape, " + std::to_string(res[0]) + " x " +
                               std::to_string(res[1]) + " pixels");
  }
  if (res[0] > kMostSide || res[1] > kMostSide || int64_t(res[0]) * res[1] > kMostPixels) {
    diagnostics_.error(
        "RENDER-RESOLUTION", scene.pos,
        "a picture of " + std::to_string(res[0]) + " x " + std::to_string(res[1]) + " pixels is too large",
        "nothing is rendered", "at most 65536 on a side and 2^31 pixels in all");
    return false;
  }
  c.resolution = res;
  std::array<float, 4> crop = scene.cropWindow;
  if (settings_.crop[0] >= 0) crop = settings_.crop;
  const auto edge = [](float f, int n) { return std::clamp(int(std::ceil(double(f) * n - 1e-6)), 0, n); };
  c.window = {edge(crop[0], res[0]), edge(crop[2], res[1]), edge(crop[1], res[0]), edge(crop[3], res[1])};
  if (c.window[0] >= c.window[2] || c.window[1] >= c.window[3]) {
    diagnostics_.error(
        "RENDER-CROP", scene.pos,
        "the crop window holds no pixel of a picture of " + std::to_string(res[0]) + " x " + std::to_string(res[1]),
        "nothing is rendered", "a pixel belongs to the window that holds its top left corner");
    return false;
  }
  tellOfCameraParameters(camera, diagnostics_);
  c.times = shutterTimes(camera, scene.hider, diagnostics_);
  c.cuts = cutPlanes(camera);
  c.shutterOpen = camera.shutter[0];
  c.shutterClose = std::max(camera.shutter[1], camera.shutter[0]);
  const double middle = 0.5 * (c.shutterOpen + c.shutterClose);
  c.worldToCamera = camera.worldToCamera.at(middle);
  if (!finite(c.worldToCamera) || std::fabs(c.worldToCamera.determinant()) < 1e-30) {
    diagnostics_.warning("RENDER-CAMERA", camera.pos, "the camera's transform is singular or not finite",
                         "the identity is used");
    camera.worldToCamera = scene::Transform();
    c.worldToCamera = scene::Matrix();
  }
  const scene::Matrix cameraToWorld = c.worldToCamera.inverse();
  if (!haveOrigin_) {
    // a render space near the camera: float keeps its precision where it is looked at; it stays when the camera moves
    for (int k = 0; k < 3; ++k) {
      const double p = cameraToWorld[3][k];
      origin_[k] = std::fabs(p) > 1024 ? std::round(p) : 0;
    }
    haveOrigin_ = true;
  }
  const bool moves = !camera.worldToCamera.isStatic() && c.shutterClose > c.shutterOpen;
  // the way back from the camera is no straight line between keys: twice as many follow it better
  const int keys =
      moves ? std::max(int(std::min<size_t>(camera.worldToCamera.matrices.size() * 2, 16)),
                       scene::uniformKeyCount(camera.worldToCamera.times, c.shutterOpen, c.shutterClose, 65))
            : 1;
  c.toRender.clear();
  c.fromRender.clear();
  scene::Matrix shift;
  shift.setTranslation(Imath::V3d(-origin_[0], -origin_[1], -origin_[2]));
  for (int k = 0; k < keys; ++k) {
    const double t = keys == 1 ? middle : c.shutterOpen + (c.shutterClose - c.shutterOpen) * k / (keys - 1);
    const scene::Matrix m = camera.worldToCamera.at(t).inverse() * shift;
    c.toRender.push_back(trace::Affine::from(m));
    c.fromRender.push_back(trace::Affine::from(m.inverse()));
  }

  ProjectionInfo info{};
  for (int k = 0; k < 4; ++k) info.screenWindow[k] = camera.screenWindow[size_t(k)];
  info.screenWindowGiven = camera.screenWindow != std::array<float, 4>{0, 0, 0, 0};
  info.frameAspect = scene.frameAspect > 0
                         ? scene.frameAspect
                         : float(res[0]) / float(res[1]) * (scene.pixelAspect > 0 ? scene.pixelAspect : 1);
  info.resolution[0] = uint32_t(res[0]);
  info.resolution[1] = uint32_t(res[1]);
  info.fStop = camera.depthOfField[0];
  info.focalLength = camera.depthOfField[1];
  info.focalDistance = camera.depthOfField[2];
  info.clipping[0] = camera.clipping[0];
  info.clipping[1] = camera.clipping[1];
  setAperture(camera, scene.hider, info);
  const scene::Matrix toCamera = camera.worldToCamera.at(middle);
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j) info.worldToCamera[4 * i + j] = toCamera[i][j];
  std::string name = camera.projection ? camera.projection->plugin : "orthographic";
  if (scene.cameras.empty()) {
    diagnostics_.warning("RENDER-NO-CAMERA", scene.pos, "the scene has no camera",
                         "an orthographic one at the origin looks along +z");
  }
  const std::string key = lowerCase(name);
  if (key == "perspective") name = "PxrPerspective";
  if (key == "orthographic") name = "PxrOrthographic";
  const Descriptor* d = registry_.find(Kind::Projection, name, diagnostics_, camera.pos);
  if (!d) {
    diagnostics_.warning("PLUGIN-MISSING", camera.projection ? camera.projection->pos : camera.pos,
                         "no projection '" + name + "'", "PxrPerspective stands in");
    d = registry_.find(Kind::Projection, "PxrPerspective", diagnostics_, camera.pos);
  }
  if (!d || !c.projection.create(*d, camera.projection.get(), nullptr, &info, host_, diagnostics_)) {
    const Descriptor* plain = registry_.find(Kind::Projection, "PxrPerspective", diagnostics_, camera.pos);
    if (!plain || !c.projection.create(*plain, nullptr, nullptr, &info, host_, diagnostics_)) return false;
  }
  c.functions = static_cast<const ProjectionFunctions*>(functionsFor(*c.projection.plugin(), width_));
  return c.functions != nullptr;
}

Placement WorldBuilder::placementOf(const scene::Transform& toWorld) const {
  Placement p{};
  scene::Matrix m = toWorld.at(0.5 * (camera_.shutterOpen + camera_.shutterClose));
  if (!finite(m)) m = scene::Matrix();
  for (int k = 0; k < 3; ++k) {
    m[3][k] -= origin_[k];
    p.worldOrigin[k] = origin_[k];
  }
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j) p.localToRender[4 * i + j] = m[i][j];
  p.isStatic = toWorld.isStatic();
  return p;
}

void WorldBuilder::flatten(const scene::Scene& scene, const std::set<uint32_t>& leaveOut) {
  parts_.clear();
  placements_.clear();
  primitiveOfShape_.clear();
  inheritedOfShape_.clear();
  inherited_.clear();
  placementInfos_.clear();
  attributesOfPlacement_.clear();
  scene::Matrix shift;
  shift.setTranslation(Imath::V3d(-origin_[0], -origin_[1], -origin_[2]));
  const scene::Transform toRender = scene::Transform::fixed(shift);
  const auto visibility = [](const scene::Attributes* a) {
    if (!a) return 15u;
    uint32_t v = 0;
    if (a->getInt("visibility:camera", 1)) v |= trace::kSeenByCamera;
    if (a->getInt("visibility:indirect", 1)) v |= trace::kSeenByIndirect;
    // "casts_shadows" is BMRT's, which old files say of skies around their scenes
    if (a->getInt("visibility:transmission", 1) && a->named.getString("render:casts_shadows", "") != "none")
      v |= trace::kSeenByOpaqueShadow | trace::kSeenByClearShadow;
    return v;
  };
  const auto place = [&](uint32_t part, const scene::Transform& toWorld, const scene::Attributes* attributes,
                         uint64_t revision, std::string name) {
    trace::PlacementInput p;
    p.part = part;
    p.visibility = visibility(attributes);
    p.toRender = concat(toWorld, toRender);
    p.revision = revision;
    shade::PlacementInfo info;
    info.name = std::move(name);
    info.priority = attributes ? attributes->getInt("trace:intersectpriority", 0) : 0;
    info.objectId = attributes ? uint32_t(attributes->getInt("identifier:id", 0)) : 0;
    info.objectId2 = attributes ? uint32_t(attributes->getInt("identifier:id2", 0)) : 0;
    info.hole = attributes && (attributes->matte || attributes->getInt("trace:holdout", 0));
    const scene::Matrix m = p.toRender.at(0.5 * (camera_.shutterOpen + camera_.shutterClose));
    info.renderToObject = trace::Affine::from(std::fabs(m.determinant()) > 1e-300 ? m.inverse() : scene::Matrix());
    placements_.push_back(std::move(p));
    placementInfos_.push_back(std::move(info));
    attributesOfPlacement_.push_back(attributes);
  };
  for (const scene::PrimitivePtr& p : scene.primitives) {
    if (leaveOut.count(p->id)) continue;
    trace::PartInput part;
    part.key = p->id;
    part.shapes.push_back(uint32_t(primitiveOfShape_.size()));
    primitiveOfShape_.push_back(p.get());
    inheritedOfShape_.push_back(nullptr);
    parts_.push_back(std::move(part));
    place(uint32_t(parts_.size() - 1), p->toWorld, p->attributes.get(), p->revision, p->name());
  }
  // prototypes in use: their primitives keep their own transform inside the prototype, so each becomes a part of its
  // own placed by every instance; nested instances are flattened (the packaged Embree has one level)
  std::map<std::tuple<uint32_t, uint32_t, std::string_view>, uint32_t> partOf;
  const auto inheritedBy = [&](const scene::AttributesPtr& own,
                               const scene::AttributesPtr& instance) -> const Inherited& {
    const auto [it, fresh] = inherited_.try_emplace({own.get(), instance.get()});
    if (fresh) {
      it->second.attributes = scene::inherit(own, instance);
      if (it->second.attributes) it->second.look = lookOf(*it->second.attributes);
    }
    return it->second;
  };
  // Prototypes that hold the next one twice, level after level, are countless also where they place nothing.
  uint64_t placed = 0, opened = 0;
  constexpr uint64_t kMostPlacements = 50'000'000, kMostIdle = 1'000'000;
  constexpr int kMostNesting = 32;
  bool isTooMany = false, isTooDeep = false;
  const auto instantiate = [&](const auto& self, const scene::Instance& inst, const scene::Transform& toWorld,
                               int depth, const scene::AttributesPtr& attributes) -> void {
    if (isTooMany || inst.prototype >= scene.prototypes.size()) return;
    if (++opened % 4096 == 0) {
      isTooMany = settings_.stop && settings_.stop->load(std::memory_order_relaxed);
      Memory::check(MemoryUse::Description);
    }
    if (depth > kMostNesting) {
      if (!isTooDeep)
        diagnostics_.warning("RENDER-INSTANCES", inst.pos,
                             "instances are nested more than " + std::to_string(kMostNesting) + " deep",
                             "what is deeper is left out");
      isTooDeep = true;
      return;
    }
    if (placed > kMostPlacements || opened > placed + kMostIdle) {
      isTooMany = true;
      diagnostics_.warning("RENDER-INSTANCES", inst.pos, "instances inside instances are too many",
                           "those after the first " + std::to_string(placed) + " objects are left out");
      return;
    }
    const scene::Prototype& proto = scene.prototypes[inst.prototype];
    for (uint32_t k = 0; k < proto.primitives.size(); ++k) {
      const scene::Primitive& p = *proto.primitives[k];
      const Inherited& inherited = inheritedBy(p.attributes, attributes);
      const auto [it, fresh] = partOf.try_emplace({inst.prototype, k, inherited.look}, uint32_t(parts_.size()));
      if (fresh) {
        trace::PartInput part;
        part.key = (uint64_t(inst.prototype) + 1) << 32 | k;
        part.instanced = true;
        part.shapes.push_back(uint32_t(primitiveOfShape_.size()));
        primitiveOfShape_.push_back(&p);
        inheritedOfShape_.push_back(&inherited);
        parts_.push_back(std::move(part));
      }
      ++placed;
      place(it->second, concat(p.toWorld, toWorld), inherited.attributes.get(), inst.revision, proto.name);
    }
    for (const scene::Instance& nested : proto.instances)
      self(self, nested, concat(nested.toWorld, toWorld), depth + 1,
           inheritedBy(nested.attributes, attributes).attributes);
  };
  for (const scene::Instance& inst : scene.instances)
    instantiate(instantiate, inst, inst.toWorld, 0, inst.attributes);
}

// The scene's own path, where '@' is the command line's, then the command line's. What the scene names relative to
// its folder is looked for there too: those folders are on the command line's path.
std::vector<std::string> WorldBuilder::searchPath(const scene::Scene& scene, const std::string& kind) const {
  const std::vector<std::string>& given = kind == "shader" ? settings_.shaderPath : settings_.texturePath;
  std::vector<std::string> path;
  const auto add = [&](const std::string& directory) {
    if (std::find(path.begin(), path.end(), directory) == path.end()) path.push_back(directory);
  };
  const std::string own = scene.options.getString("searchpath:" + kind, "");
  for (size_t at = 0; at < own.size();) {
    const size_t colon = std::min(own.find(':', at), own.size());
    const std::string part = own.substr(at, colon - at);
    at = colon + 1;
    if (part.empty() || part == "&") continue;
    if (part == "@") {
      for (const std::string& d : given) add(d);
      continue;
    }
    add(part);
    if (part[0] != '/')
      for (const std::string& d : given) add(d + "/" + part);
  }
  for (const std::string& d : given) add(d);
  return path;
}

void WorldBuilder::openTextures(const scene::Scene& scene) {
  contents_.begin();
  if (image::Colors::ofEnvironment().isManaged())
    contents_.use("colour configuration", "OCIO", {std::string(std::getenv("OCIO"))});
  textures_->setSearchPath(searchPath(scene, "texture"));
  volumes_->setSearchPath(searchPath(scene, "texture"));
}

bool WorldBuilder::buildWorld(const scene::Scene& scene, const film::LightPaths& paths, Statistics& statistics) {
  const auto start = std::chrono::steady_clock::now();
  std::set<uint32_t> lightShapes;
  const std::vector<scene::Light> lightsToUse = lightsToRender(scene, registry_, diagnostics_, lightShapes);
  flatten(scene, lightShapes);
  tellOfDisplacements(scene, registry_, shaders_, diagnostics_);

  // Dice rates: the finest over all placements of a shape. Distances are taken to the camera's position.
  const scene::Matrix cameraToWorld = camera_.worldToCamera.inverse();
  const Imath::V3d eye = cameraToWorld.translation();
  // half the height of the picture at distance 1, as the projection's own spread says, is not known here: take the
  // angle of a pixel from the first ray's footprint
  double pixelAngle = 1.0 / camera_.resolution[1];
  double pixelSize = 0;
  {
    alignas(64) float raster[2][16], lens[2][16], time[16], o[3][16], d[3][16], w[16], radius[16], spread[16];
    for (int i = 0; i < 16; ++i) {
      raster[0][i] = 0.5f * float(camera_.resolution[0]);
      raster[1][i] = 0.5f * float(camera_.resolution[1]);
      lens[0][i] = lens[1][i] = time[i] = 0.5f;
    }
    const CameraSampleArgs a{
        1,     {raster[0], raster[1]}, {lens[0], lens[1]}, time, {o[0], o[1], o[2]}, {d[0], d[1], d[2]}, w, radius,
        spread};
    camera_.functions->rays(camera_.projection.data(), &a);
    if (spread[0] > 0)
      pixelAngle = 2.0 * spread[0];
    else
      pixelAngle = 0;
    pixelSize = 2.0 * radius[0];
  }
  const size_t count = primitiveOfShape_.size();
  std::vector<std::vector<uint32_t>> placementsOfShape(count);
  for (uint32_t i = 0; i < placements_.size(); ++i)
    for (uint32_t s : parts_[placements_[i].part].shapes)
      if (placementsOfShape[s].size() < 64) placementsOfShape[s].push_back(i);  // enough for dicing
  std::vector<std::shared_ptr<geometry::Mesh>> meshes(count);
  const bool mirrored = camera_.worldToCamera.determinant() < 0;
  // what a mesh takes from the camera besides its dicing, which stays as it is when the camera moves
  const std::string fixedSettings = mirrored ? "mirrored" : "";
  const std::string movingSettings =
      fixedSettings + " " + std::to_string(camera_.shutterOpen) + " " + std::to_string(camera_.shutterClose);
  const auto settingsOf = [&](const scene::Primitive& p) -> const std::string& {
    return p.motion.empty() && p.toWorld.isStatic() ? fixedSettings : movingSettings;
  };
  const auto keyOf = [&](size_t i) {
    return std::pair<uint64_t, std::string>(primitiveOfShape_[i]->id,
                                            inheritedOfShape_[i] ? inheritedOfShape_[i]->look : std::string());
  };
  tbb::parallel_for(size_t(0), count, [&](size_t i) {
    scene::Primitive asInherited;
    const scene::Primitive* source = primitiveOfShape_[i];
    if (const Inherited* from = inheritedOfShape_[i];
        from && from->attributes && (!source->attributes || lookOf(*source->attributes) != from->look)) {
      asInherited = *source;
      asInherited.attributes = from->attributes;
      source = &asInherited;
    }
    const scene::Primitive& p = *source;
    if (const auto it = shapes_.find(keyOf(i));
        it != shapes_.end() && it->second.revision == p.revision && it->second.settings == settingsOf(p)) {
      meshes[i] = it->second.mesh;
      return;
    }
    if (settings_.stop && settings_.stop->load(std::memory_order_relaxed)) return;
    // not less than the description holds; the true size is charged when it is known
    MemoryHold coming(MemoryUse::Meshes);
    coming.add(scene::bytesHeld(p));
    geometry::DiceRate rate;
    rate.worldMirrored = mirrored;
    const double length = p.attributes ? p.attributes->named.getFloat("dice:micropolygonlength", 1) : 1;
    const double pixels = kPixelsPerEdge * (length > 0 ? length : 1);
    // nearest placements' transforms, object -> world, with the length they give to an object unit
    struct Use {
      scene::Matrix m;
      double scale;
    };
    std::vector<Use> uses;
    for (uint32_t k : placementsOfShape[i]) {
      scene::Matrix m = placements_[k].toRender.at(0.5 * (camera_.shutterOpen + camera_.shutterClose));
      for (int c = 0; c < 3; ++c) m[3][c] += origin_[c];
      const double scale = std::cbrt(std::fabs(m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) -
                                               m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
                                               m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0])));
      if (scale > 0 && std::isfinite(scale)) uses.push_back({m, scale});
    }
    rate.edgeLength = [uses, eye, pixelAngle, pixelSize, pixels](const Imath::V3d& x) {
      double best = INFINITY;
      for (const Use& u : uses) {
        const double distance = (x * u.m - eye).length();
        best = std::min(best, std::max(pixelSize, distance * pixelAngle) * pixels / u.scale);
      }
      return best;
    };
    std::optional<geometry::Mesh> mesh = geometry::tessellate(p, rate, diagnostics_);
    if (mesh) uniformKeys(*mesh, camera_.shutterOpen, camera_.shutterClose);
    meshes[i] = std::make_shared<geometry::Mesh>(mesh ? std::move(*mesh) : geometry::Mesh());
    coming.set(0);
    meshesHeld_.add(meshes[i]->bytes());
  });
  if (settings_.stop && settings_.stop->load()) return false;
  shapeInputs_.clear();
  std::map<std::pair<uint64_t, std::string>, Kept> kept;
  for (size_t i = 0; i < count; ++i) {
    const scene::Primitive& p = *primitiveOfShape_[i];
    const std::pair<uint64_t, std::string> key = keyOf(i);
    const auto before = shapes_.find(key);
    const bool same = before != shapes_.end() && before->second.mesh == meshes[i];
    // each look of a primitive has its own key in the world
    uint64_t variant = 0;
    for (auto it = kept.lower_bound({p.id, ""}); it != kept.end() && it->first.first == p.id; ++it) ++variant;
    const Kept& mine = kept[key] =
        Kept{p.revision, settingsOf(p), same ? before->second.made : ++meshesMade_, meshes[i]};
    trace::ShapeInput in;
    in.key = p.id | variant << 32;
    in.revision = mine.made;
    in.mesh = meshes[i];
    shapeInputs_.push_back(std::move(in));
  }
  shapes_ = std::move(kept);

  // Materials
  auto materials = std::make_shared<shade::MaterialSet>(registry_, diagnostics_, *textures_, width_, paths, shaders_);
  auto next = std::make_unique<shade::ShadingWorld>();
  std::map<std::array<float, 3>, scene::NetworkPtr> colored;  // geometry without a material shows its Cs
  for (size_t k = 0; k < placements_.size(); ++k) {
    const scene::Attributes* a = attributesOfPlacement_[k];
    const scene::Primitive& p = primitiveOf(placements_[k]);
    const scene::NetworkPtr* network = a && a->bxdf ? &a->bxdf : nullptr;
    if (!network && p.primvars.find("Cs")) {
      scene::NetworkPtr& made = colored[a && a->color ? *a->color : std::array<float, 3>{1, 1, 1}];
      if (!made) made = shade::colorPrimvarNetwork(a);
      network = &made;
    }
    placementInfos_[k].material = materials->add(network ? *network : nullptr, a, p.pos);
  }
  materials->finish();
  // what stops shadow rays follows from what shapes are made of, in any of their places
  for (trace::ShapeInput& shape : shapeInputs_)
    shape.visibility = trace::kSeenByCamera | trace::kSeenByIndirect | trace::kSeenByOpaqueShadow;
  for (size_t k = 0; k < placements_.size(); ++k) {
    const shade::Program& program = materials->program((*materials)[placementInfos_[k].material].program);
    if (program.opaque && !program.tints) continue;
    uint32_t& visibility = shapeInputs_[parts_[placements_[k].part].shapes[0]].visibility;
    visibility = (visibility & ~uint32_t(trace::kSeenByOpaqueShadow)) | trace::kSeenByClearShadow;
  }

  traceSets(*next);
  trace::BuildOptions options;
  options.shutterOpen = camera_.shutterOpen;
  options.shutterClose = camera_.shutterClose;
  options.watertight = scene.hider && scene.hider->params.getInt("jitter", 1) == 0;
  const trace::BuildCounters before = counters_;
  const auto world = trace::World::build(shapeInputs_, parts_, placements_, options,
                                         shading_ ? shading_->world.get() : nullptr, counters_);
  statistics.bvhPartsBuilt += counters_.partsBuilt - before.partsBuilt;
  statistics.bvhBuilds += counters_.topLevelBuilds - before.topLevelBuilds;

  shade::ShadingWorld& w = *next;
  w.world = world;
  w.materials = materials;
  w.width = width_;
  w.textures = textures_.get();
  w.volumes = volumes_.get();
  w.diagnostics = &diagnostics_;
  w.samples = pmj02Table();
  w.paths = &paths;
  for (int k = 0; k < 3; ++k) w.worldOrigin[k] = origin_[k];
  const bool softTerminator = !scene.hider || scene.hider->params.getInt("geomShadowTermBias", 1) != 0;
  // geometry infos in the world's own order: meshes are recognised by their address
  std::map<const geometry::Mesh*, uint32_t> shapeOfMesh;
  for (uint32_t i = 0; i < count; ++i) shapeOfMesh[shapeInputs_[i].mesh.get()] = i;
  w.geometries.resize(world->geometryCount());
  for (uint32_t g = 0; g < world->geometryCount(); ++g) {
    const geometry::Mesh& mesh = world->mesh(g);
    const uint32_t s = shapeOfMesh.at(&mesh);
    const scene::Primitive& p = *primitiveOfShape_[s];
    shade::GeometryInfo& info = w.geometries[g];
    // what faces the ray has no back, and normals that the user gave are turned already
    info.side = mesh.flipNormals && !mesh.facesRay() && !mesh.isOriented() ? -1.f : 1.f;
    info.N = mesh.find("N");
    if (info.N && (info.N->width != 3 || info.N->data.empty())) info.N = nullptr;
    const auto coordinates = [&](const char* name, int least) {
      const geometry::Primvar* v = mesh.find(name);
      return v && v->width >= least && !v->data.empty() ? v : nullptr;
    };
    info.st = coordinates("st", 2);
    info.s = coordinates("s", 1);
    info.t = coordinates("t", 1);
    const bool lifts = softTerminator && info.N && info.N->rate != geometry::Primvar::Rate::PerFace &&
                       info.N->rate != geometry::Primvar::Rate::Constant &&
                       std::holds_alternative<scene::PolygonMesh>(p.shape);
    w.liftsShadows |= lifts;
    info.flags = (lifts ? shade::kLiftsShadows : 0u) | (info.N ? shade::kHasNormals : 0u) |
                 (mesh.doubleSided ? 0u : shade::kOneSided) | (mesh.quads ? shade::kHasQuads : 0u);
    info.name = p.name();
    for (const geometry::Primvar& v : mesh.primvars)
      if (!v.data.empty() && v.width > 0) {
        uint32_t& width = w.primvarWidths[v.name];
        width = std::max(width, uint32_t(std::min(v.width, 3)));
      }
    w.hasPresence |= (info.flags & shade::kOneSided) != 0;
  }
  // what every object answers (shade/implied_primvars.h); Color and Opacity only where some request gave one
  for (const auto& [name, least] : {std::pair{"st", 2u}, {"s", 1u}, {"t", 1u}}) {
    uint32_t& width = w.primvarWidths[name];
    width = std::max(width, least);
  }
  w.tints.push_back({});
  std::map<shade::Tint, uint32_t> tintOf{{{}, 0}};
  for (size_t k = 0; k < placements_.size(); ++k) {
    const scene::Attributes* a = attributesOfPlacement_[k];
    shade::Tint tint;
    tint.hasColor = a && a->color;
    tint.hasOpacity = a && a->opacity;
    if (tint.hasColor) {
      tint.color = *a->color;
      w.primvarWidths["Cs"] = 3;
    }
    if (tint.hasOpacity) {
      tint.opacity = *a->opacity;
      w.primvarWidths["Os"] = 3;
    }
    const auto [it, fresh] = tintOf.try_emplace(tint, uint32_t(w.tints.size()));
    if (fresh) w.tints.push_back(tint);
    placementInfos_[k].tint = it->second;
  }
  for (uint32_t m = 0; m < materials->size(); ++m) {
    w.hasMedia |= materials->encloses(m);
    w.hasTintedShadows |= materials->tints(m);
    w.hasPresence |= !materials->opaque(m);
  }
  scene::Matrix shift;
  shift.setTranslation(Imath::V3d(-origin_[0], -origin_[1], -origin_[2]));
  w.spaces["world"] = shift;
  w.spaces["camera"] = cameraToWorld * shift;
  for (const auto& [name, t] : scene.coordinateSystems)
    w.spaces[name] = t.at(0.5 * (camera_.shutterOpen + camera_.shutterClose)) * shift;

  if (!materials->shaderUses().empty()) {
    w.shaders = std::make_shared<shade::ShaderScene>(diagnostics_);
    w.shaders->ofPlacement = attributesOfPlacement_;
    w.shaders->camera = cameraAttributes(scene, camera_);
  }

  const LinkSets linkSetOf = linkObjects(scene, lightsToUse);
  for (const shade::PlacementInfo& info : placementInfos_) w.hasHoles |= info.hole;
  w.placements = placementInfos_;
  w.fillTables();
  shading_ = std::move(next);
  shading_->lights = makeLights(scene, lightsToUse, paths, linkSetOf);
  statistics.lights = shading_->lights->size();

  statistics.primitives = count;
  statistics.instances = placements_.size();
  statistics.triangles = world->triangleCount();
  statistics.materials = materials->size();
  statistics.programs = materials->programCount();
  statistics.shaders.clear();
  for (const shade::ShaderUse* use : materials->shaderUses())
    statistics.shaders.push_back({use->name, materials->materialsOf(*use), 0, 0, 0, 0, 0, 0, {}});
  statistics.shadersCompiled = shaders_.compiled();
  statistics.shaderPrograms = shaders_.executables().size();
  statistics.shaderCompileSeconds = shaders_.compileSeconds();
  statistics.buildSeconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  meshesHeld_.set(world->meshBytes());
  statistics.memory.clear();
  statistics.memory.push_back({"bvh (Embree)", trace::World::embreeBytes()});
  statistics.memory.push_back({"meshes", world->meshBytes()});
  statistics.memory.push_back({"scene description", scene.bytes()});
  statistics.memory.push_back({"materials", materials->bytes()});
  if (materials->shaderBytes()) statistics.memory.push_back({"shader programs", materials->shaderBytes()});
  statistics.memory.push_back({"instances", placements_.size() * (sizeof(trace::Instance) + sizeof(trace::Affine) +
                                                                  sizeof(shade::PlacementInfo))});
  return true;
}

}  // namespace kinora::render
