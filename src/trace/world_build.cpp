// How a World is made: which placements are baked into batches, instances and swarms, the top level. Parts are built in
// part_build.cpp, solids in world_solids.cpp.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>
#include <set>
#include <tuple>

#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>

#include "scene/uniform_keys.h"
#include "trace/embree_device.h"
#include "trace/strands.h"
#include "trace/world_part.h"

namespace kinora::trace {

namespace {

constexpr uint32_t kBatchTriangles = 200000;

int keyCountFor(const scene::Transform& t, double open, double close) {
  if (t.isStatic() || close <= open) return 1;
  return scene::uniformKeyCount(t.times, open, close, scene::kMostUniformKeys);
}

// Three coordinates of 21 bits, their bits in turn.
uint64_t interleaved(const double x[3]) {
  uint64_t code = 0;
  for (int k = 0; k < 3; ++k) {
    const auto q = uint64_t(std::clamp(x[k], 0., 1.) * 2097151);
    for (int b = 0; b < 21; ++b) code |= (q >> b & 1) << (3 * b + k);
  }
  return code;
}

// Placements with what they are ordered by.
struct Ordered {
  uint32_t visibility, placement;
  uint64_t code;
  bool operator<(const Ordered& o) const {
    return std::tie(visibility, code, placement) < std::tie(o.visibility, o.code, o.placement);
  }
};

// What lies together in space shall lie together in memory: a ray that passes many placements waits for little else.
void sortBySpace(std::vector<Ordered>& placements, const std::function<Imath::V3d(uint32_t)>& placeOf) {
  std::vector<Imath::V3f> places(placements.size());
  tbb::parallel_for(size_t(0), places.size(),
                    [&](size_t i) { places[i] = Imath::V3f(placeOf(placements[i].placement)); });
  Imath::Box3f all;
  const auto isFinite = [](const Imath::V3f& x) { return std::isfinite(x.x + x.y + x.z); };
  for (const Imath::V3f& x : places)
    if (isFinite(x)) all.extendBy(x);
  const double size =
      all.isEmpty() ? 1 : std::max({double(all.size().x), double(all.size().y), double(all.size().z), 1e-30});
  tbb::parallel_for(size_t(0), places.size(), [&](size_t i) {
    double x[3] = {0, 0, 0};
    for (int k = 0; k < 3 && isFinite(places[i]); ++k) x[k] = (double(places[i][k]) - double(all.min[k])) / size;
    placements[i].code = interleaved(x);
  });
  tbb::parallel_sort(placements.begin(), placements.end());
}

}  // namespace

std::shared_ptr<const World> World::build(std::vector<ShapeInput> shapes, std::vector<PartInput> partInputs,
                                          const PlacementSource& placements, const BuildOptions& options,
                                          const World* previous, BuildCounters& counters,
                                          const std::vector<SolidInput>& solids) {
  auto world = std::shared_ptr<World>(new World());
  World& w = *world;
  w.watertight_ = options.watertight;
  w.unread_ = options.unread;
  for (ShapeInput& s : shapes)
    if (!s.mesh) s.mesh = std::make_shared<geometry::Mesh>();
  std::vector<uint32_t> uses(partInputs.size(), 0);
  for (uint32_t i = 0; i < placements.size(); ++i) ++uses[placements[i].part];

  // Which parts are baked into batches: static, placed once, not a prototype.
  struct Plan {
    std::vector<uint32_t> placements;
    std::vector<uint32_t> plain;  // placements that may be in a swarm
    std::vector<uint32_t> shapes;
    bool batch = false, ofSolid = false, hasUser = false;
    bool isDense = false;  // of micropolygons, which rays meet at edges often enough to see it
    uint32_t triangles = 0;
    const std::vector<uint32_t>* visibility = nullptr;  // by place in `shapes`; null: the shapes' own
    uint32_t part = kNone;                              // once it is made
    Imath::V3d origin{0, 0, 0};
  };
  std::vector<Plan> plans;
  std::vector<uint32_t> planOfPart(partInputs.size(), kNone);
  uint32_t openBatch = kNone;
  const auto toRenderOf = [&](uint32_t placement) {
    return options.toRender ? options.toRender(placement) : placements[placement].toRender;
  };
  const auto stillToRender = [&](uint32_t placement, scene::Matrix& m) {
    if (options.stillToRender && options.stillToRender(placement, m)) return true;
    const scene::Transform t = toRenderOf(placement);
    if (keyCountFor(t, options.shutterOpen, options.shutterClose) != 1) return false;
    m = t.at(0.5 * (options.shutterOpen + options.shutterClose));
    return true;
  };
  const auto revisionOf = [&](uint32_t placement) {
    return options.revisionOf ? options.revisionOf(placement) : placements[placement].revision;
  };
  uint64_t plainCount = 0;
  for (uint32_t i = 0; i < placements.size(); ++i) {
    const PlacementInput place = placements[i];
    const PartInput& in = partInputs[place.part];
    const bool ofSolid = place.member.solid != kNoSolid;
    bool bakes = !ofSolid && !in.instanced && uses[place.part] == 1;
    uint32_t triangles = 0;
    if (bakes || planOfPart[place.part] == kNone) {
      const scene::Transform toRender = bakes ? toRenderOf(i) : scene::Transform();
      bakes &= keyCountFor(toRender, options.shutterOpen, options.shutterClose) == 1;
      for (uint32_t s : in.shapes) {
        triangles += shapes[s].mesh->primitiveCount();
        bakes &= !shapes[s].user;
        if (shapes[s].mesh->isStrand()) bakes &= keepsWidths(toRender.matrices[0]);
      }
    }
    if (bakes) {
      const bool small = triangles < options.smallShape;
      if (!small || openBatch == kNone || plans[openBatch].triangles + triangles > kBatchTriangles) {
        plans.push_back({});
        plans.back().batch = true;
        if (small) openBatch = uint32_t(plans.size() - 1);
      }
      Plan& plan = small ? plans[openBatch] : plans.back();
      plan.triangles += triangles;
      for (uint32_t s : in.shapes) {
        plan.placements.push_back(i);  // one entry a shape
        plan.shapes.push_back(s);
      }
    } else {
      if (planOfPart[place.part] == kNone) {
        planOfPart[place.part] = uint32_t(plans.size());
        plans.push_back({});
        plans.back().shapes = in.shapes;
        if (!in.visibility.empty()) plans.back().visibility = &in.visibility;
        plans.back().triangles = triangles;
        for (const uint32_t s : in.shapes) plans.back().hasUser |= shapes[s].user != nullptr;
      }
      Plan& plan = plans[planOfPart[place.part]];
      plan.ofSolid |= ofSolid;
      scene::Matrix m;
      const bool isPlain = !plan.hasUser && !plan.ofSolid && placements.size() >= options.swarmFrom &&
                           !options.placesOnly && stillToRender(i, m);
      (isPlain ? plan.plain : plan.placements).push_back(i);
    }
  }
  for (Plan& plan : plans) {
    if (!plan.ofSolid) plainCount += plan.plain.size();
  }
  for (Plan& plan : plans) {
    if (plan.plain.empty() || (plainCount >= options.swarmFrom && !plan.ofSolid)) continue;
    plan.placements.insert(plan.placements.end(), plan.plain.begin(), plan.plain.end());
    std::sort(plan.placements.begin(), plan.placements.end());
    plan.plain.clear();
  }

  const auto visibilityIn = [&](const Plan& plan, size_t i) {
    return plan.visibility ? (*plan.visibility)[i] : shapes[plan.shapes[i]].visibility;
  };
  w.instances_->reserve(placements.size());
  w.keys_->reserve(placements.size());
  const auto instanceFor = [&](uint32_t user) {
    const PlacementInput place = placements[user];
    Instance inst;
    inst.user = user;
    inst.info = place.info == PlacementInput::kOwn ? user : place.info;
    inst.isUnit = partInputs[place.part].isUnit;
    return inst;
  };
  const auto addInstance = [&](uint32_t user, const Imath::V3d& origin, bool baked) {
    Instance inst = instanceFor(user);
    inst.baked = baked;
    inst.firstKey = uint32_t(w.keys_->size());
    const scene::Transform toRender = baked ? scene::Transform() : toRenderOf(user);
    const int n = baked ? 1 : keyCountFor(toRender, options.shutterOpen, options.shutterClose);
    inst.keyCount = uint16_t(n);
    for (int k = 0; k < n; ++k) {
      if (baked) {
        w.keys_->push_back(Affine());
        continue;
      }
      const double t = n == 1 ? 0.5 * (options.shutterOpen + options.shutterClose)
                              : options.shutterOpen + (options.shutterClose - options.shutterOpen) * k / (n - 1);
      w.keys_->push_back(Affine::from(scene::Matrix().setTranslation(origin) * toRender.at(t)));
    }
    w.instances_->push_back(inst);
    return uint32_t(w.instances_->size() - 1);
  };

  // Parts: kept from the previous world when all they hold is unchanged.
  std::map<uint64_t, std::shared_ptr<const Part>> old;
  std::set<const geometry::Mesh*> baked;  // already in render space
  if (previous)
    for (const auto& p : previous->parts_) {
      old.emplace(p->key, p);
      if (p->batch)
        for (const auto& m : p->meshes) baked.insert(m.get());
    }
  struct Top {
    uint32_t part, instance;
    uint32_t visibility;
  };
  std::vector<Top> tops;
  float lower[3] = {INFINITY, INFINITY, INFINITY}, upper[3] = {-INFINITY, -INFINITY, -INFINITY};
  const auto grow = [&](const float from[3], const float to[3], const Affine& a) {
    for (int c = 0; c < 8; ++c) {
      const float q[3] = {c & 1 ? to[0] : from[0], c & 2 ? to[1] : from[1], c & 4 ? to[2] : from[2]};
      float r[3];
      a.point(q, r);
      for (int k = 0; k < 3; ++k) {
        if (!std::isfinite(r[k])) continue;
        lower[k] = std::min(lower[k], r[k]);
        upper[k] = std::max(upper[k], r[k]);
      }
    }
  };
  const auto isDelayed = [&](uint32_t placement) { return options.isDelayed && options.isDelayed(placement); };
  for (const UnreadBounds::Box& b : options.delayed) grow(b.lower, b.upper, Affine());
  for (Plan& plan : plans) {
    if (plan.shapes.empty()) continue;
    for (const uint32_t s : plan.shapes) plan.isDense |= !shapes[s].mesh->rest.empty() || shapes[s].user;
    const uint64_t key = shapes[plan.shapes[0]].key * 2 + (plan.batch ? 1 : 0);
    std::vector<std::pair<uint64_t, uint64_t>> identity;
    for (size_t i = 0; i < plan.shapes.size(); ++i) {
      const ShapeInput& s = shapes[plan.shapes[i]];
      identity.emplace_back(s.key, s.revision);
      identity.emplace_back(visibilityIn(plan, i), plan.batch ? placements[plan.placements[i]].visibility : 0);
      if (plan.batch) identity.emplace_back(revisionOf(plan.placements[i]), 0);
    }
    std::shared_ptr<const Part> part;
    const bool isWatertight = options.watertight || plan.ofSolid || plan.isDense;
    if (const auto it = old.find(key); it != old.end() && it->second->identity == identity &&
                                       it->second->watertight == isWatertight &&
                                       it->second->ofSolid == plan.ofSolid) {
      part = it->second;
      ++counters.partsKept;
    } else {
      const auto made = std::make_shared<Part>();
      made->key = key;
      made->identity = identity;
      made->batch = plan.batch;
      made->watertight = isWatertight;
      made->ofSolid = plan.ofSolid;
      for (size_t i = 0; i < plan.shapes.size(); ++i) {
        ShapeInput& s = shapes[plan.shapes[i]];
        uint32_t visibility = visibilityIn(plan, i);
        if (plan.batch) {
          const PlacementInput place = placements[plan.placements[i]];
          if (!baked.count(s.mesh.get()))
            bake(*s.mesh, toRenderOf(plan.placements[i]).at(0.5 * (options.shutterOpen + options.shutterClose)));
          visibility &= place.visibility;
        }
        made->meshes.push_back(s.mesh);
        made->users.push_back(s.user);
        made->visibility.push_back(visibility);
      }
      if (!options.placesOnly) made->build();
      part = made;
      ++counters.partsBuilt;
    }
    PartPlace placeInTables;
    placeInTables.firstGeometry = uint32_t(w.meshes_.size());
    for (const auto& m : part->meshes) {
      w.infoStep_.push_back(plan.batch ? 0 : uint32_t(w.meshes_.size()) - placeInTables.firstGeometry);
      w.meshes_.push_back(m);
      w.moving_ |= m->keyCount() > 1;
      w.hasStrands_ |= m->isStrand();
      w.hasFacing_ |= m->facesRay();
      w.hasRibbons_ |= m->facesRay() && m->isCurve();
    }
    for (size_t i = 0; i < part->users.size(); ++i)
      if (part->users[i] && part->users[i]->hasFacets()) {
        w.faceted_.resize(w.meshes_.size(), nullptr);
        w.faceted_[placeInTables.firstGeometry + i] = part->users[i].get();
      }
    for (uint32_t v : part->visibility) w.clearShadows_ |= (v & kSeenByClearShadow) && !(v & kSeenByOpaqueShadow);
    w.hasUser_ |= part->hasUser;
    const uint32_t partIndex = uint32_t(w.parts_.size());
    w.parts_.push_back(part);
    if (plan.batch) {
      placeInTables.firstInstance = uint32_t(w.instances_->size());
      for (size_t i = 0; i < plan.shapes.size(); ++i) addInstance(plan.placements[i], Imath::V3d(0), true);
      tops.push_back({partIndex, kNone, 0xffffffffu});
      grow(part->lower, part->upper, Affine());
      for (const auto& m : part->meshes) w.triangles_ += m->triangleCount();
    } else {
      const Imath::V3d origin = part->meshes.empty() ? Imath::V3d(0) : part->meshes[0]->origin;
      uint64_t triangles = 0;
      for (const auto& m : part->meshes) triangles += m->triangleCount();
      for (uint32_t i : plan.placements) {
        const uint32_t instance = addInstance(i, origin, false);
        tops.push_back({partIndex, instance, placements[i].visibility});
        const Instance& added = (*w.instances_)[instance];
        w.moving_ |= added.keyCount > 1;
        for (uint32_t k = 0; k < added.keyCount && !isDelayed(i); ++k)
          grow(part->lower, part->upper, (*w.keys_)[added.firstKey + k]);
        w.triangles_ += triangles;
      }
      plan.part = partIndex;
      plan.origin = origin;
      w.triangles_ += triangles * plan.plain.size();
    }
    placeInTables.firstTarget = uint32_t(w.targets_.size());
    for (size_t g = 0; g + 1 < part->firstSlice.size(); ++g) {
      const uint32_t first = part->firstSlice[g];
      const Part::Slice& s = part->slices[first];
      w.targets_.push_back({placeInTables.firstGeometry + s.shape, placeInTables.firstInstance + s.shape,
                            part->firstSlice[g + 1] - first > 1, part->users[s.shape] != nullptr});
    }
    w.places_.push_back(placeInTables);
  }

  // Placements in swarms stand last, those of one visibility together.
  std::vector<Ordered> inSwarms;
  w.firstOfSwarms_ = uint32_t(w.instances_->size());
  if (plainCount) inSwarms.reserve(plainCount);
  for (Plan& plan : plans) {
    for (const uint32_t i : plan.plain) inSwarms.push_back({placements[i].visibility, i, 0});
    std::vector<uint32_t>().swap(plan.plain);
  }
  if (!inSwarms.empty()) {
    sortBySpace(inSwarms, [&](uint32_t placement) {
      scene::Matrix m;
      stillToRender(placement, m);
      return m.translation();
    });
    const uint32_t first = w.firstOfSwarms_, firstKey = uint32_t(w.keys_->size());
    w.instances_->resize(first + inSwarms.size());
    w.keys_->resize(firstKey + inSwarms.size());
    tbb::parallel_for(size_t(0), inSwarms.size(), [&](size_t i) {
      const uint32_t placement = inSwarms[i].placement;
      Instance inst = instanceFor(placement);
      inst.firstKey = firstKey + uint32_t(i);
      scene::Matrix m;
      stillToRender(placement, m);
      (*w.keys_)[inst.firstKey] =
          Affine::from(scene::Matrix().setTranslation(plans[planOfPart[placements[placement].part]].origin) * m);
      (*w.instances_)[first + i] = inst;
    });
    for (size_t i = 0; i < inSwarms.size(); ++i) {
      const uint32_t plan = planOfPart[placements[inSwarms[i].placement].part], part = plans[plan].part;
      const Instance& inst = (*w.instances_)[first + i];
      if (w.partOfInfo_->size() <= inst.info) w.partOfInfo_->resize(inst.info + 1, kNone);
      (*w.partOfInfo_)[inst.info] = part;
      if (i == 0 || inSwarms[i].visibility != inSwarms[i - 1].visibility)
        w.seenFrom_.emplace_back(first + uint32_t(i), inSwarms[i].visibility);
      if (!isDelayed(inSwarms[i].placement))
        grow(w.parts_[part]->lower, w.parts_[part]->upper, (*w.keys_)[inst.firstKey]);
    }
    std::vector<Ordered>().swap(inSwarms);
  }
  w.key_ = w.keys_->data();
  w.instance_ = w.instances_->data();
  if (!w.faceted_.empty()) w.faceted_.resize(w.meshes_.size(), nullptr);
  if (options.placesOnly) return world;
  if (lower[0] <= upper[0]) {
    float r2 = 0;
    for (int k = 0; k < 3; ++k) {
      w.center_[k] = 0.5f * (lower[k] + upper[k]);
      r2 += 0.25f * (upper[k] - lower[k]) * (upper[k] - lower[k]);
    }
    w.radius_ = std::sqrt(r2);
  }
  w.findLost();
  const bool hasSwarms = w.firstOfSwarms_ < w.instances_->size();
  // not where it would follow from what has been read
  w.single_ = tops.size() == 1 && tops[0].instance == kNone && !hasSwarms && options.delayed.empty();
  for (auto* list : {&w.partOfTop_, &w.instanceOfTop_, &w.visibilityOfTop_}) list->reserve(tops.size());
  for (const Top& t : tops) {
    w.partOfTop_.push_back(t.part);
    w.instanceOfTop_.push_back(t.instance);
    w.visibilityOfTop_.push_back(t.instance != kNone && !w.isLost_.empty() && w.isLost_[t.instance] ? 0
                                                                                                    : t.visibility);
  }
  if (w.single_) {
    w.top_ = w.parts_[0]->scene;
    rtcRetainScene(w.top_);
  } else if (previous && w.sameTop(*previous)) {
    w.top_ = previous->top_;
    w.swarms_ = previous->swarms_;
    rtcRetainScene(w.top_);
  } else {
    w.top_ = rtcNewScene(device());
    if (options.watertight) rtcSetSceneFlags(w.top_, RTC_SCENE_FLAG_ROBUST);
    for (uint32_t i = 0; i < tops.size(); ++i) {
      const RTCGeometry g = w.makeInstance(i);
      rtcSetGeometryMask(g, w.visibilityOfTop_[i]);
      rtcCommitGeometry(g);
      if (!w.isLost_.empty() && tops[i].instance != kNone && w.isLost_[tops[i].instance]) rtcDisableGeometry(g);
      rtcAttachGeometryByID(w.top_, g, i);
      rtcReleaseGeometry(g);
    }
    w.makeSwarms();
    rtcCommitScene(w.top_);
    throwIfRefused();
    ++counters.topLevelBuilds;
  }
  if (!solids.empty()) w.buildSolids(solids, placements);
  for (const auto& part : w.parts_)
    for (const uint32_t v : part->visibility)
      if ((v & kAskedAlone) && !w.freeSpace_) w.freeSpace_ = std::make_unique<const FreeSpace>();
  return world;
}

// One for each visibility, which Embree asks of a geometry.
void World::makeSwarms() {
  if (seenFrom_.empty()) return;
  std::vector<RTCScene> scenes;
  for (const auto& p : parts_) scenes.push_back(p->scene);
  const auto firstId = uint32_t(partOfTop_.size());
  auto isLost = std::make_shared<const std::vector<bool>>(isLost_);
  for (uint32_t k = 0; k < seenFrom_.size(); ++k) {
    const uint32_t begin = seenFrom_[k].first,
                   end = k + 1 < seenFrom_.size() ? seenFrom_[k + 1].first : uint32_t(instances_->size());
    const auto& swarm = swarms_.emplace_back(std::make_shared<const Swarm>(
        Swarm::Data{instances_, keys_, partOfInfo_, isLost, scenes}, begin, end, firstId + (begin - firstOfSwarms_)));
    const RTCGeometry g = swarm->makeGeometry(device());
    rtcSetGeometryMask(g, seenFrom_[k].second);
    rtcCommitGeometry(g);
    rtcAttachGeometryByID(top_, g, firstId + k);
    rtcReleaseGeometry(g);
  }
}

RTCGeometry World::makeInstance(uint32_t top) const {
  const RTCGeometry g = rtcNewGeometry(device(), RTC_GEOMETRY_TYPE_INSTANCE);
  rtcSetGeometryInstancedScene(g, parts_[partOfTop_[top]]->scene);
  const uint32_t instance = instanceOfTop_[top];
  const uint32_t keys = instance == kNone ? 1 : instance_[instance].keyCount;
  rtcSetGeometryTimeStepCount(g, keys);
  for (uint32_t k = 0; k < keys; ++k) {
    const Affine a = instance == kNone ? Affine() : key_[instance_[instance].firstKey + k];
    const float m[12] = {a.m[0][0], a.m[1][0], a.m[2][0], a.m[0][1], a.m[1][1], a.m[2][1],
                         a.m[0][2], a.m[1][2], a.m[2][2], a.t[0],    a.t[1],    a.t[2]};
    rtcSetGeometryTransform(g, k, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, m);
  }
  return g;
}

// An edit that moved nothing (a light, the camera) leaves the top level as it is.
bool World::sameTop(const World& previous) const {
  if (previous.single_ || parts_ != previous.parts_ || partOfTop_ != previous.partOfTop_ ||
      instanceOfTop_ != previous.instanceOfTop_ || visibilityOfTop_ != previous.visibilityOfTop_ ||
      seenFrom_ != previous.seenFrom_ || isLost_ != previous.isLost_ || keys_->size() != previous.keys_->size() ||
      instances_->size() != previous.instances_->size())
    return false;
  for (uint32_t i = 0; i < instances_->size(); ++i) {
    const Instance &a = instance_[i], &b = previous.instance_[i];
    if (a.firstKey != b.firstKey || a.keyCount != b.keyCount) return false;
    if (i >= firstOfSwarms_ && (*partOfInfo_)[a.info] != (*previous.partOfInfo_)[b.info]) return false;
  }
  return keys_->empty() || std::memcmp(key_, previous.key_, keys_->size() * sizeof(Affine)) == 0;
}

}  // namespace kinora::trace
