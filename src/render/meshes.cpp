#include "render/meshes.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <optional>
#include <unordered_map>

#include "geometry/join.h"
#include "geometry/tessellate.h"
#include "render/matrix_scale.h"
#include "scene/bytes.h"
#include "scene/digests.h"
#include "scene/uniform_keys.h"
#include "trace/transformed_geometry.h"

namespace kinora::render {

namespace {

// Micropolygon edge at dice:micropolygonlength 1. Where surfaces are not displaced their normals are exact anyway.
constexpr double kPixelsPerEdge = 2.0, kPixelsPerDisplacedEdge = 1.0;
// Edges of quadrics that are to be patches, in those of a micropolygon.
constexpr double kCoarserQuadric = 6;

// What a mesh takes from camera and shutter besides its dicing; what bounds a solid or a medium stays in its own space.
Digest settingsOf(const FlatScene::Shape& shape, bool isOfSolid, const CameraState& camera,
                  const Digest& displacement) {
  const scene::Primitive& p = *shape.primitive;
  Hasher h;
  h.digest(displacement);
  h.word(uint64_t(isOfSolid) | uint64_t(shape.isBaked) << 1);
  h.word(camera.isMirrored());
  h.bytes(camera.origin, sizeof camera.origin);  // it may be brought into render space for good
  const bool isStill = p.motion.empty() && p.toWorld.isStatic();
  h.word(isStill);
  if (!isStill)
    for (const double t : {camera.shutterOpen, camera.shutterClose}) h.bytes(&t, sizeof t);
  return h.result();
}

// Length of a micropolygon's edge.
double pixelsOf(const scene::Attributes* a, bool isDisplaced) {
  const double usual = isDisplaced ? kPixelsPerDisplacedEdge : kPixelsPerEdge;
  if (!a) return usual;
  const float length = a->named.getFloat("dice:micropolygonlength", 0);
  // the older request is about areas
  if (isDisplaced && !(length > 0) && a->says(scene::Attributes::kShadingRate))
    return usual * std::sqrt(double(a->shadingRate));
  return usual * (length > 0 ? double(length) : 1);
}

// A placed use of a shape, for its dicing: object -> world, with the length that it gives to an object unit.
struct Use {
  scene::Matrix m;
  double scale;
};

constexpr size_t kMostUses = 64;  // placements that a shape is diced for

std::vector<std::vector<Use>> usesOf(const FlatScene& flat, const CameraState& camera) {
  std::vector<std::vector<Use>> uses(flat.shapes.size());
  std::vector<uint32_t> looked(flat.shapes.size(), 0);
  for (uint32_t k = 0; k < flat.placements.size(); ++k)
    for (const uint32_t s : flat.parts[flat.partOf(k)].shapes) {
      if (flat.shapes[s].radiusPixels > 0 || looked[s]++ >= kMostUses) continue;
      scene::Matrix m = flat.toRender(k).at(camera.middle());
      if (flat.shapes[s].isBaked) m = flat.shapes[s].primitive->toWorld.at(camera.middle()) * m;
      for (int c = 0; c < 3; ++c) m[3][c] += camera.origin[c];
      const double scale = scaleOf(m);
      if (scale > 0 && std::isfinite(scale)) uses[s].push_back({m, scale});
    }
  return uses;
}

Digest dicingOf(const std::vector<Use>& uses, const CameraState& camera) {
  Hasher h;
  const Imath::V3d eye = camera.worldToCamera.inverse().translation();
  for (const double v : {eye.x, eye.y, eye.z, camera.pixelAngle, camera.pixelSize}) h.bytes(&v, sizeof v);
  if (camera.beam) {
    h.bytes(camera.beam->data(), sizeof *camera.beam);
    h.bytes(&camera.worldToCamera, sizeof camera.worldToCamera);
  }
  for (const Use& u : uses) h.bytes(&u.m, sizeof u.m);
  return h.result();
}

// How large a micropolygon's edge is for a camera without perspective, in those that it sees: 1 where it looks and a
// quarter of the picture's diagonal around, longer with the distance beyond, so that what reaches to the horizon has an
// end.
class BeamRate {
 public:
  explicit BeamRate(const CameraState& camera) : camera_(camera) {
    if (!camera.beam) return;
    const std::array<double, 4>& b = *camera.beam;
    around_ = 0.25 * std::hypot(b[2] - b[0], b[3] - b[1]);
  }
  double at(const Imath::V3d& world) const {
    if (!(around_ > 0)) return 1;
    const Imath::V3d p = world * camera_.worldToCamera;
    const std::array<double, 4>& b = *camera_.beam;
    const double x = std::max({b[0] - p.x, p.x - b[2], 0.0}), y = std::max({b[1] - p.y, p.y - b[3], 0.0});
    return std::max(1.0, std::hypot(x, y) / around_);
  }
  double slope() const { return around_ > 0 ? 1 / around_ : 0; }  // by length in camera space

 private:
  const CameraState& camera_;
  double around_ = 0;
};

// Of all that a mesh holds: a field more and this does not compile.
Digest digestOf(const geometry::Mesh& mesh) {
  Hasher h;
  const auto values = [&](const auto& list) { h.bytes(list.data(), list.size() * sizeof list[0]); };
  const auto& [kind, spine, spineNormals, along, own, points, origin, rest, vertexCount, times, indices,
               faceOfTriangle, quads, quadPairs, cornerUV, vertexUV, primvars, flipNormals, doubleSided, bounds] =
      mesh;
  h.word(uint64_t(kind) | uint64_t(quads) << 8 | uint64_t(quadPairs) << 9 | uint64_t(flipNormals) << 10 |
         uint64_t(doubleSided) << 11);
  h.word(vertexCount);
  values(spine), values(spineNormals), values(along), values(own), values(points), values(rest), values(times),
      values(indices);
  values(faceOfTriangle), values(cornerUV), values(vertexUV);
  h.bytes(&origin, sizeof origin);
  h.bytes(&bounds, sizeof bounds);
  h.word(primvars.size());
  for (const geometry::Primvar& p : primvars) {
    const auto& [name, type, width, rate, data, strings] = p;
    h.text(name);
    h.word(uint64_t(type) | uint64_t(rate) << 8 | uint64_t(uint32_t(width)) << 16);
    values(data);
    h.word(strings.size());
    for (const std::string& s : strings) h.text(s);
  }
  return h.result();
}

}  // namespace

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
  const int keys = scene::uniformKeyCount(mesh.times, open, close, scene::kMostUniformKeys);
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

// The meshes of the world before, each to be taken once.
class Meshes::Finder {
 public:
  explicit Finder(std::vector<Kept>& kept) : kept_(kept), isTaken_(kept.size(), false) {
    for (size_t i = 0; i < kept.size(); ++i) {
      byAddress_.emplace(kept[i].source.get(), i);
      byId_.emplace(kept[i].source->id, i);
    }
  }
  // The one that was made of the same; null: there is none.
  Kept* find(const FlatScene::Shape& shape, const Digest& settings) {
    const scene::Primitive* p = shape.primitive.get();
    const auto fits = [&](size_t i) {
      return !isTaken_[i] && kept_[i].look == shape.look && kept_[i].settings == settings &&
             (kept_[i].more == shape.more || (kept_[i].more && shape.more && *kept_[i].more == *shape.more));
    };
    for (auto [it, end] = byAddress_.equal_range(p); it != end; ++it)
      if (fits(it->second)) return take(it->second);
    std::optional<Digest> own;
    for (auto [it, end] = byId_.equal_range(p->id); it != end; ++it) {
      if (!fits(it->second) || kept_[it->second].source.get() == p) continue;
      if (!own) own = scene::ownDigestOf(*p);
      if (scene::ownDigestOf(*kept_[it->second].source) == *own) return take(it->second);
    }
    return nullptr;
  }

 private:
  Kept* take(size_t i) {
    isTaken_[i] = true;
    return &kept_[i];
  }
  std::vector<Kept>& kept_;
  std::vector<bool> isTaken_;
  std::unordered_multimap<const scene::Primitive*, size_t> byAddress_;
  std::unordered_multimap<uint32_t, size_t> byId_;
};

Meshes::Kept Meshes::tessellated(const FlatScene& flat, size_t index, const geometry::DiceRate& rate,
                                 const CameraState& camera, const Displacement& displacement,
                                 const std::atomic<bool>* stop, const std::atomic<bool>& isDiced,
                                 Diagnostics& diagnostics) {
  const FlatScene::Shape& shape = flat.shapes[index];
  Kept kept;
  kept.source = shape.primitive;
  kept.look = shape.look;
  kept.more = shape.more;
  scene::Primitive asInherited;
  const scene::Primitive* p = shape.primitive.get();
  if (shape.radiusPixels == 0 && shape.attributes != p->attributes && lookOf(p->attributes.get()) != shape.look) {
    asInherited = *p;
    asInherited.attributes = shape.attributes;
    p = &asInherited;
  }
  Displacement::Found found;
  if (!shape.more && displacement.mayHaveLevels(index)) {
    geometry::DiceRate flat = rate;
    flat.isDisplaced = false;
    // outlines of smooth quadrics hold a small part of a pixel; patches need not
    if (std::holds_alternative<scene::Quadric>(p->shape))
      flat.edgeLength = [&rate](const Imath::V3d& x) { return kCoarserQuadric * rate.at(x); };
    Diagnostics unheard([](const std::string&, Severity) {});  // it is made once more where it has no levels
    std::optional<geometry::Mesh> base = geometry::tessellate(*p, flat, unheard);
    if (base) {
      uniformKeys(*base, camera.shutterOpen, camera.shutterClose);
      kept.levels = displacement.levelled(index, rate, pixelsOf(shape.attributes.get(), true), stop, *base, found);
    }
    if (kept.levels) {
      kept.mesh = kept.levels->patches()->mesh();
      kept.user = kept.levels;
      const scene::Matrix own = scene::Matrix().setTranslation(kept.mesh->origin) * p->toWorld.matrices[0];
      if (shape.isBaked && own != scene::Matrix()) {
        // it is diced and displaced in its own space; what lies on it is asked for in that of the part
        kept.user = std::make_shared<trace::TransformedGeometry>(kept.levels, own);
        kept.mesh = std::make_shared<geometry::Mesh>(*kept.mesh);
        trace::bake(*kept.mesh, p->toWorld.matrices[0]);
      }
      kept.isDiced = isDiced;
      return kept;  // another camera, another surface: nothing of the content is compared
    }
  }
  if (rate.isStopped()) {  // all of it is thrown away
    kept.mesh = std::make_shared<geometry::Mesh>();
    return kept;
  }
  std::optional<geometry::Mesh> mesh = geometry::tessellate(*p, rate, diagnostics);
  if (shape.more) {
    std::vector<geometry::Mesh> all;
    if (mesh) all.push_back(std::move(*mesh));
    for (const scene::PrimitivePtr& one : *shape.more)
      if (std::optional<geometry::Mesh> m = geometry::tessellate(*one, rate, diagnostics))
        all.push_back(std::move(*m));
    mesh.reset();
    if (!all.empty()) mesh = geometry::joined(all);
  }
  if (mesh) uniformKeys(*mesh, camera.shutterOpen, camera.shutterClose);
  if (mesh && rate.isDisplaced) displacement.apply(index, rate, stop, *mesh, found);
  if (mesh && shape.isBaked && (mesh->origin != Imath::V3d(0) || p->toWorld.matrices[0] != scene::Matrix()))
    trace::bake(*mesh, p->toWorld.matrices[0]);
  kept.mesh = std::make_shared<geometry::Mesh>(mesh ? std::move(*mesh) : geometry::Mesh());
  kept.isDiced = isDiced;
  if (isDiced) kept.content = digestOf(*kept.mesh);
  return kept;
}

bool Meshes::make(const FlatScene& flat, const CameraState& camera, const Displacement& displacement,
                  const std::atomic<bool>* stop, Diagnostics& diagnostics, Rebuilt& made) {
  const size_t count = flat.shapes.size();
  const std::vector<std::vector<Use>> uses = usesOf(flat, camera);
  std::vector<bool> isOfSolid(count, false);
  for (uint32_t k = 0; k < flat.placements.size() && !flat.solids.empty(); ++k)
    if (flat.memberOf(k).solid != trace::kNoSolid)
      for (const uint32_t s : flat.parts[flat.partOf(k)].shapes) isOfSolid[s] = true;
  const Imath::V3d eye = camera.worldToCamera.inverse().translation();
  const BeamRate beam(camera);
  std::vector<Kept> before = std::move(kept_);
  kept_.clear();
  Finder finder(before);
  std::vector<Kept> next(count);
  std::vector<Kept*> found(count);
  std::vector<uint32_t> missing;
  for (uint32_t i = 0; i < count; ++i) {
    const FlatScene::Shape& shape = flat.shapes[i];
    const Digest settings = settingsOf(shape, isOfSolid[i] || shape.boundsMedia, camera, displacement.digestOf(i));
    found[i] = finder.find(shape, settings);
    if (found[i] && !(found[i]->isDiced && found[i]->dicing != dicingOf(uses[i], camera))) {
      next[i] = std::move(*found[i]);
      next[i].source = shape.primitive;
    } else {
      next[i].settings = settings;
      missing.push_back(i);
    }
  }
  tbb::parallel_for(size_t(0), missing.size(), [&](size_t k) {
    if (stop && stop->load(std::memory_order_relaxed)) return;
    const uint32_t i = missing[k];
    const FlatScene::Shape& shape = flat.shapes[i];
    // not less than the description holds; the true size is charged when it is known
    MemoryHold coming(MemoryUse::Meshes);
    coming.add(scene::bytesHeld(*shape.primitive));
    geometry::DiceRate rate;
    rate.worldMirrored = camera.isMirrored();
    rate.isDisplaced = displacement.moves(i);
    const double pixels = pixelsOf(shape.attributes.get(), rate.isDisplaced);
    rate.pixelsPerEdge = pixels;
    rate.stop = stop;
    std::atomic<bool> isDiced = false;
    rate.edgeLength = [&](const Imath::V3d& x) {
      if (shape.radiusPixels > 0) return pixels / shape.radiusPixels;  // its look says how it is diced
      isDiced.store(true, std::memory_order_relaxed);
      double best = INFINITY;
      for (const Use& u : uses[i]) {
        const Imath::V3d world = x * u.m;
        const double distance = (world - eye).length();
        best = std::min(best,
                        std::max(camera.pixelSize * beam.at(world), distance * camera.pixelAngle) * pixels / u.scale);
      }
      return best;
    };
    if (shape.radiusPixels == 0) {
      rate.slope = std::max(camera.pixelAngle, camera.pixelSize * beam.slope()) * pixels;
      for (const Use& u : uses[i]) {
        const double least = camera.pixelSize * pixels / u.scale;
        rate.least = rate.least > 0 ? std::min(rate.least, least) : least;
      }
    }
    Kept mine = tessellated(flat, i, rate, camera, displacement, stop, isDiced, diagnostics);
    coming.set(0);
    mine.settings = next[i].settings;
    mine.dicing = dicingOf(uses[i], camera);
    if (found[i] && !mine.levels && !found[i]->levels && mine.isDiced == found[i]->isDiced &&
        mine.content == found[i]->content) {
      // the camera sees it otherwise, and it is diced as before: what was built of it stays
      mine.mesh = found[i]->mesh;
      mine.serial = found[i]->serial;
    } else {
      held_.add(mine.mesh->bytes());
      if (mine.levels && mine.levels->patches()->mesh() != mine.mesh)
        held_.add(mine.levels->patches()->mesh()->bytes());
    }
    next[i] = std::move(mine);
  });
  if (stop && stop->load()) return false;
  for (const uint32_t i : missing)
    if (next[i].serial == 0) {
      next[i].serial = ++lastSerial_;
      ++made.meshes;
    }
  kept_ = std::move(next);
  return true;
}

std::vector<trace::ShapeInput> Meshes::shapes() const {
  std::vector<trace::ShapeInput> out(kept_.size());
  std::unordered_map<uint32_t, uint64_t> variants;  // each look of a primitive has its own key in the world
  for (size_t i = 0; i < kept_.size(); ++i) {
    const uint32_t id = kept_[i].source->id;
    out[i].key = id | variants[id]++ << 32;
    out[i].revision = kept_[i].serial;
    out[i].mesh = kept_[i].mesh;
    out[i].user = kept_[i].user;
  }
  return out;
}

bool Meshes::forgetLevelled() {
  const size_t before = kept_.size();
  std::erase_if(kept_, [](const Kept& k) { return k.levels != nullptr; });
  return kept_.size() < before;
}

uint64_t Meshes::levelledBytes() const {
  uint64_t sum = 0;
  for (const Kept& k : kept_) sum += k.levels ? k.levels->bytes() : 0;
  return sum;
}

uint64_t Meshes::levelledQuads() const {
  uint64_t sum = 0;
  for (const Kept& k : kept_) sum += k.levels ? k.levels->patches()->triangles() / 2 : 0;
  return sum;
}

std::vector<const geometry::Mesh*> Meshes::all() const {
  std::vector<const geometry::Mesh*> out;
  for (const Kept& k : kept_) out.push_back(k.mesh.get());
  return out;
}

std::vector<uint64_t> Meshes::serials() const {
  std::vector<uint64_t> out;
  for (const Kept& k : kept_) out.push_back(k.serial);
  return out;
}

}  // namespace kinora::render
