#include "render/flat_scene.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <tuple>

#include "base/memory.h"
#include "render/detail.h"
#include "render/prototype_parts.h"
#include "render/solid_trees.h"
#include "scene/digests.h"

namespace kinora::render {

Digest lookOf(const scene::Attributes* attributes) {
  static const scene::Attributes kUsual;
  const scene::Attributes& a = attributes ? *attributes : kUsual;
  Hasher h;
  h.word(uint64_t(a.orientation) | uint64_t(a.reverseOrientation) << 8 | uint64_t(a.displacement != nullptr) << 9);
  const auto isOfDisplacement = [&](const std::string& name) {
    return a.displacement &&
           (name.starts_with("displacementbound:") || name.starts_with("user:") || name == "trace:displacements");
  };
  if (a.displacement) {
    h.digest(scene::digestOf(*a.displacement));
    h.bytes(&a.shadingRate, sizeof a.shadingRate);
    for (const auto* color : {&a.color, &a.opacity}) {
      h.word(color->has_value());
      if (*color) h.bytes((*color)->data(), sizeof **color);
    }
  }
  for (const int v : {a.sides, a.uStep, a.vStep}) h.word(uint64_t(v));
  h.bytes(a.textureCoordinates.data(), sizeof a.textureCoordinates);
  for (const auto* basis : {&a.uBasis, &a.vBasis}) h.bytes(basis->data(), sizeof *basis);
  for (const scene::Parameter& p : a.named)
    if (p.name.starts_with("dice:") || p.name.starts_with("polygon:") || p.name.starts_with("trimcurve:") ||
        p.name.starts_with("hair:") || isOfDisplacement(p.name)) {
      h.text(p.name);
      h.bytes(p.floats.data(), p.floats.size() * sizeof(float));
      h.bytes(p.ints.data(), p.ints.size() * sizeof(int));
      h.word(p.strings.size());
      for (const std::string& v : p.strings) h.text(v);
    }
  return h.result();
}

namespace {

bool areSame(const scene::Transform& a, const scene::Transform& b) {
  return a.times == b.times && a.matrices == b.matrices;
}
bool areSame(const scene::InstanceList& a, const scene::InstanceList& b) {
  return a.isLike(b, [](const scene::Instance& x, const scene::Instance& y) {
    return x.prototype == y.prototype && x.solid == y.solid && x.attributes == y.attributes &&
           areSame(x.toWorld, y.toWorld);
  });
}

float noiseToleranceOf(const scene::Attributes* a) {
  const float x = a ? a->named.getFloat("shade:relativepixelvariance", 1) : 1.f;
  return x > 0 ? std::clamp(x, 1e-3f, 1e3f) : 1.f;  // NaN as well
}

uint32_t visibilityOf(const scene::Attributes* a) {
  if (!a) return 15u;
  uint32_t v = 0;
  if (a->getInt("visibility:camera", 1)) v |= trace::kSeenByCamera;
  if (a->getInt("visibility:indirect", 1)) v |= trace::kSeenByIndirect;
  // "casts_shadows" is BMRT's, which old files say of skies around their scenes
  if (a->getInt("visibility:transmission", 1) && a->named.getString("render:casts_shadows", "") != "none")
    v |= trace::kSeenByOpaqueShadow | trace::kSeenByClearShadow;
  return v;
}

}  // namespace

const scene::Primitive& FlatScene::primitiveOf(const Placement& p) const {
  return p.opened == kWorld ? *primitives_[p.primitive] : *prototypes_[prototypeOf(p.opened)].primitives[p.primitive];
}

scene::Transform FlatScene::toWorld(uint32_t opened) const {
  if (opened == kWorld) return {};
  if (isInWorld(opened)) return instances_.toWorldOf(opened);
  const Opened& o = nested(opened);
  return concat(listAround(o).toWorldOf(o.place), toWorld(o.around));
}

uint64_t FlatScene::nextSerial() {
  static std::atomic<uint64_t> last{0};
  return ++last;
}

bool FlatScene::stillToWorld(uint32_t opened, scene::Matrix& m) const {
  if (isInWorld(opened)) return instances_.stillToWorld(opened, m);
  const Opened& o = nested(opened);
  scene::Matrix own;
  if (!listAround(o).stillToWorld(o.place, own)) return false;
  // neighbours in memory and in space stand in the same instance
  struct Known {
    uint64_t serial = 0;
    uint32_t opened = 0;
    bool isStill = false;
    scene::Matrix m;
  };
  static thread_local std::array<Known, 64> known;
  Known& k = known[o.around % known.size()];
  if (k.serial != serial_ || k.opened != o.around) {
    const bool isStill = stillToWorld(o.around, m);  // which may take the same place for another
    k = {serial_, o.around, isStill, m};
  }
  if (!k.isStill) return false;
  m = own * k.m;
  return true;
}

scene::Transform FlatScene::toRender(uint32_t placement) const {
  const Placement& p = placements[placement];
  if (p.primitive == kMany) return concat(toWorld(p.opened), worldToRender_);
  const scene::Primitive& source = primitiveOf(p);
  scene::Transform t = p.opened == kWorld ? source.toWorld : concat(source.toWorld, toWorld(p.opened));
  if (parts[kinds[p.kind].part].isUnit)
    t = concat(scene::Transform::fixed(scene::Matrix().setScale(unitQuadricOf(source)->size)), t);
  return concat(t, worldToRender_);
}

bool FlatScene::stillToRender(uint32_t placement, scene::Matrix& m) const {
  const Placement& p = placements[placement];
  if (p.opened == kWorld || parts[kinds[p.kind].part].isUnit) {
    const scene::Transform t = toRender(placement);
    if (t.isStatic()) m = t.matrices[0];
    return t.isStatic();
  }
  if (!stillToWorld(p.opened, m)) return false;
  if (p.primitive != kMany) {
    const scene::Transform& own = primitiveOf(p).toWorld;
    if (!own.isStatic()) return false;
    m = own.matrices[0] * m;
  }
  m = m * worldToRender_.matrices[0];
  return true;
}

std::string FlatScene::nameOf(uint32_t placement) const {
  const Placement& p = placements[placement];
  return p.opened == kWorld ? primitiveOf(p).name() : prototypes_[prototypeOf(p.opened)].name;
}

bool FlatScene::isOf(const scene::Scene& scene, const RenderSpace& space, const std::set<uint32_t>& leaveOut) const {
  return space_.origin == space.origin && space_.view.middle == space.view.middle &&
         (!asksView_ || space_ == space) && leaveOut_ == leaveOut && primitives_ == scene.primitives &&
         solids_ == scene.solids && areSame(instances_, scene.instances) &&
         std::equal(prototypes_.begin(), prototypes_.end(), scene.prototypes.begin(), scene.prototypes.end(),
                    [](const scene::Prototype& a, const scene::Prototype& b) {
                      return a.name == b.name && a.primitives == b.primitives && a.solids == b.solids &&
                             areSame(a.instances, b.instances);
                    });
}

class Flattener {
 public:
  Flattener(const scene::Scene& scene, const RenderSpace& space, const std::set<uint32_t>& leaveOut,
            const std::function<bool(const scene::Attributes*)>& boundsMedia, const std::atomic<bool>* stop,
            Diagnostics& diagnostics)
      : scene_(scene),
        boundsMedia_(boundsMedia),
        stop_(stop),
        diagnostics_(diagnostics),
        flat_(std::make_shared<FlatScene>()),
        trees_(diagnostics) {
    flat_->primitives_ = scene.primitives;
    flat_->instances_ = scene.instances;
    flat_->placements.reserve(scene.primitives.size() + scene.instances.size());
    flat_->prototypes_ = scene.prototypes;
    flat_->solids_ = scene.solids;
    flat_->space_ = space;
    flat_->leaveOut_ = leaveOut;
    scene::Matrix shift;
    shift.setTranslation(Imath::V3d(-space.origin[0], -space.origin[1], -space.origin[2]));
    flat_->worldToRender_ = scene::Transform::fixed(shift);
  }

  std::shared_ptr<const FlatScene> run() {
    FlatScene& f = *flat_;
    const std::vector<SolidTrees::Place> solids = trees_.open(scene_.solids, {});
    std::set<uint32_t> alone = f.leaveOut_;  // what bounds media shares no shape
    for (const scene::PrimitivePtr& p : scene_.primitives)
      if (boundsMedia(p->attributes.get())) alone.insert(p->id);
    const SharedShapes shared = sharedShapesOf(scene_.primitives, f.space_.view, alone,
                                               [&](const scene::Attributes* a) { return lookOfLast(a); });
    f.asksView_ |= shared.asksView;
    std::vector<uint32_t> partOfGroup(shared.groups.size(), kNone);
    for (uint32_t k = 0; k < scene_.primitives.size(); ++k) {
      const scene::PrimitivePtr& p = scene_.primitives[k];
      if (f.leaveOut_.count(p->id) || !isSeen(p->attributes.get(), FlatScene::kWorld)) continue;
      if (const uint32_t g = shared.of(k); g != SharedShapes::kNone) {
        const bool isFirst = partOfGroup[g] == kNone;
        if (isFirst) partOfGroup[g] = addShared(shared.groups[g]);
        if (isFirst || shared.groups[g].isUnit) place(partOfGroup[g], FlatScene::kWorld, k, p->attributes.get(), {});
        continue;
      }
      const SolidTrees::Place in = placeIn(solids, p->solid, {}, [&] { return p->pos; });
      const scene::AttributesPtr& look = trees_.isTurned(in) ? turned(p->attributes) : p->attributes;
      const uint32_t part = addPart(p->id, false, {p, look, lookOfLast(look.get())});
      place(part, FlatScene::kWorld, k, p->attributes.get(), in);
    }
    openAll(scene_.instances, FlatScene::kWorld, 0, nullptr, solids, {});
    f.solids = trees_.finish(f.solidPlaces);
    for (trace::Solids::Member& m : f.members_) m = trees_.resolved(m);
    f.spaces = std::move(spaces_);
    return std::move(flat_);
  }

 private:
  uint32_t addPart(uint64_t key, bool isInstanced, FlatScene::Shape shape) {
    trace::PartInput part;
    part.key = key;
    part.instanced = isInstanced;
    part.shapes.push_back(uint32_t(flat_->shapes.size()));
    flat_->shapes.push_back(std::move(shape));
    flat_->parts.push_back(std::move(part));
    return uint32_t(flat_->parts.size() - 1);
  }

  uint32_t addShared(const SharedShapes::Group& group) {
    const scene::PrimitivePtr& first = scene_.primitives[group.members[0]];
    const Digest look = lookOfLast(first->attributes.get());
    if (!group.isUnit) {
      auto more = std::make_shared<std::vector<scene::PrimitivePtr>>();
      more->reserve(group.members.size() - 1);
      for (size_t i = 1; i < group.members.size(); ++i) more->push_back(scene_.primitives[group.members[i]]);
      return addPart(first->id, false, {first, first->attributes, look, 0, std::move(more)});
    }
    auto unit = std::make_shared<scene::Primitive>(*first);
    unit->shape = unitQuadricOf(*first)->quadric;
    unit->toWorld = scene::Transform();
    Hasher h;  // not what this primitive would be by itself
    h.digest(look);
    h.bytes(&group.radiusPixels, sizeof group.radiusPixels);
    const uint32_t part =
        addPart(first->id, true, {std::move(unit), first->attributes, h.result(), group.radiusPixels});
    flat_->parts[part].isUnit = true;
    return part;
  }

  // Most objects share the attributes of the one before.
  Digest lookOfLast(const scene::Attributes* a) {
    if (!isLookKnown_ || a != lastLook_.first) lastLook_ = {a, lookOf(a)};
    isLookKnown_ = true;
    return lastLook_.second;
  }

  // Of the solid with this number, from 1, in a list that has these places; 0: what stands around the list.
  template <class Said>
  SolidTrees::Place placeIn(const std::vector<SolidTrees::Place>& places, uint32_t solid,
                            const SolidTrees::Place& around, const Said& posOf) {
    if (solid == 0) return around;
    if (solid <= places.size()) return places[solid - 1];
    const SourcePos pos = posOf();
    diagnostics_.warning("RENDER-SOLID", pos,
                         "an object is a part of solid number " + std::to_string(solid) + ", and there are " +
                             std::to_string(places.size()),
                         "it is drawn as it is", "an edit that removes a solid removes its parts too");
    return {};
  }

  // With the other side out.
  const scene::AttributesPtr& turned(const scene::AttributesPtr& attributes) {
    scene::AttributesPtr& out = turned_[attributes];
    if (!out) {
      auto made =
          attributes ? std::make_shared<scene::Attributes>(*attributes) : std::make_shared<scene::Attributes>();
      made->reverseOrientation = !made->reverseOrientation;
      out = std::move(made);
    }
    return out;
  }

  void place(uint32_t part, uint32_t opened, uint32_t primitive, const scene::Attributes* attributes,
             const SolidTrees::Place& in) {
    if (boundsMedia(attributes)) {
      flat_->shapes[flat_->parts[part].shapes[0]].boundsMedia = true;
      flat_->parts[part].instanced = true;  // in its own space, for those who look for its boundary
    }
    placeKind(kindOf(part, attributes), opened, primitive, in);
  }

  void placeKind(uint32_t kind, uint32_t opened, uint32_t primitive, const SolidTrees::Place& in) {
    FlatScene& f = *flat_;
    f.placements.push_back({kind, opened, primitive});
    const auto placement = uint32_t(f.placements.size() - 1);
    const bool ofSolid = in.solid != trace::kNoSolid;
    if (!ofSolid && opened != FlatScene::kWorld) {
      if (!f.members_.empty()) f.members_.emplace_back();
      return;
    }
    const scene::Transform toRender = f.toRender(placement);
    if (ofSolid) f.members_.resize(placement);
    if (ofSolid || !f.members_.empty()) f.members_.push_back(trees_.add(in, toRender));
    if (opened != FlatScene::kWorld) return;
    scene::Matrix m = toRender.at(f.space_.view.middle);
    double unit = 1;
    if (f.parts[f.kinds[kind].part].isUnit) {
      unit = unitQuadricOf(*scene_.primitives[primitive])->size;
      m = scene::Matrix().setScale(1 / unit) * m;
    }
    spaces_->push_back(shade::ObjectSpace::of(m, float(unit)));
  }

  // Of what stands in an opened instance.
  bool isSeen(const scene::Attributes* a, uint32_t opened) {
    if (a == lastWithout_ || !hasDetail(a)) {
      lastWithout_ = a;
      return true;
    }
    flat_->asksView_ = true;
    return isDrawn(a, flat_->toWorld(opened), flat_->space_.view, double(relativeDetail_));
  }

  uint32_t kindOf(uint32_t part, const scene::Attributes* attributes) {
    FlatScene& f = *flat_;
    if (!f.kinds.empty() && f.kinds.back().part == part && f.attributes.back() == attributes)
      return uint32_t(f.kinds.size() - 1);
    if (f.parts[part].instanced) {
      const auto [it, isNew] = kinds_.try_emplace({part, attributes}, uint32_t(f.kinds.size()));
      if (!isNew) return it->second;
    }
    addKind(part, f.parts[part].shapes[0], attributes);
    return uint32_t(f.kinds.size() - 1);
  }

  void addKind(uint32_t part, uint32_t shape, const scene::Attributes* attributes) {
    FlatScene& f = *flat_;
    if (attributes != lastAttributes_ || f.kinds.empty()) {
      lastAttributes_ = attributes;
      lastVisibility_ = visibilityOf(attributes);
      shade::PlacementInfo& info = lastInfo_;
      info = {};
      info.priority = attributes ? attributes->getInt("trace:intersectpriority", 0) : 0;
      info.objectId = attributes ? uint32_t(attributes->getInt("identifier:id", 0)) : 0;
      info.objectId2 = attributes ? uint32_t(attributes->getInt("identifier:id2", 0)) : 0;
      info.noiseTolerance = noiseToleranceOf(attributes);
      info.isHiddenFromCamera = !(lastVisibility_ & trace::kSeenByCamera);
      info.hole = attributes && (attributes->matte || attributes->getInt("trace:holdout", 0));
    }
    f.kinds.push_back({part, shape, lastVisibility_});
    f.infos.push_back(lastInfo_);
    f.attributes.push_back(attributes);
  }

  bool boundsMedia(const scene::Attributes* attributes) {
    const scene::Network* material = attributes ? attributes->bxdf.get() : nullptr;
    if (!material) return false;
    if (material != lastMaterial_) {
      lastMaterial_ = material;
      lastBoundsMedia_ = boundsMedia_(attributes);
    }
    return lastBoundsMedia_;
  }

  const std::pair<scene::AttributesPtr, Digest>& inheritedBy(const scene::AttributesPtr& own,
                                                             const scene::AttributesPtr& instance) {
    const auto [it, isNew] = flat_->inherited_.try_emplace({own.get(), instance.get()});
    if (isNew) {
      it->second.first = scene::inherit(own, instance);
      it->second.second = lookOf(it->second.first.get());
    }
    return it->second;
  }

  // A primitive of an object, as some instance gives it.
  struct Given {
    uint32_t primitive;
    scene::AttributesPtr attributes;  // with the side out that faces out
    const scene::Attributes* inherited;
    Digest look;
    SolidTrees::Place in;
  };

  // The primitives of an object that are one part. The first of its kinds; kNone: there are none, all stand for
  // themselves.
  uint32_t kindsOfMany(uint32_t prototype, const scene::Attributes* attributes, const std::vector<Given>& many) {
    if (many.size() < 2) return kNone;
    const scene::Prototype& proto = scene_.prototypes[prototype];
    Hasher h;
    for (const Given& g : many) {
      h.word(g.primitive);
      h.digest(g.look);
    }
    FlatScene& f = *flat_;
    const auto [it, isNew] = partOf_.try_emplace({prototype, FlatScene::kMany, h.result()}, 0);
    if (isNew) {
      it->second = addPart((uint64_t(prototype) + 1) << 32 | many[0].primitive, true,
                           {proto.primitives[many[0].primitive], many[0].attributes, many[0].look});
      f.shapes.back().isBaked = true;
      for (size_t i = 1; i < many.size(); ++i) {
        f.parts.back().shapes.push_back(uint32_t(f.shapes.size()));
        f.shapes.push_back({proto.primitives[many[i].primitive], many[i].attributes, many[i].look});
        f.shapes.back().isBaked = true;
      }
    }
    const uint32_t part = it->second;
    const auto [kind, isNewKind] = kinds_.try_emplace({part, attributes}, uint32_t(f.kinds.size()));
    for (size_t i = 0; isNewKind && i < many.size(); ++i) addKind(part, f.parts[part].shapes[i], many[i].inherited);
    return kind->second;
  }

  // What primitives of an object may be one part is; each of the others is a part of its own that every instance
  // places. Nested instances are flattened (the packaged Embree has one level).
  void open(const scene::InstanceList& list, uint32_t index, uint32_t within, int depth,
            const scene::AttributesPtr& attributes, const SolidTrees::Place& around) {
    const uint32_t prototype = list.prototypeOf(index);
    // Objects that hold the next one twice, level after level, are countless also where they place nothing.
    constexpr uint64_t kMostPlacements = 50'000'000, kMostIdle = 1'000'000;
    constexpr int kMostNesting = 32;
    if (isTooMany_) return;
    if (prototype >= scene_.prototypes.size()) {
      diagnostics_.warning("RENDER-INSTANCE-GONE", list[index].pos,
                           "an instance is of object number " + std::to_string(prototype) + ", and the scene has " +
                               std::to_string(scene_.prototypes.size()),
                           "the instance is left out", "an edit that removes an object removes its instances too");
      return;
    }
    if (++opened_ % 4096 == 0) {
      isTooMany_ = stop_ && stop_->load(std::memory_order_relaxed);
      Memory::check(MemoryUse::Description);
    }
    if (depth > kMostNesting) {
      if (!isTooDeep_)
        diagnostics_.warning("RENDER-INSTANCES", list[index].pos,
                             "instances are nested more than " + std::to_string(kMostNesting) + " deep",
                             "what is deeper is left out");
      isTooDeep_ = true;
      return;
    }
    if (placed_ > kMostPlacements || opened_ > 2 * placed_ + kMostIdle) {
      isTooMany_ = true;
      diagnostics_.warning("RENDER-INSTANCES", list[index].pos, "instances inside instances are too many",
                           "those after the first " + std::to_string(placed_) + " objects are left out");
      return;
    }
    const scene::Prototype& proto = scene_.prototypes[prototype];
    const std::vector<SolidTrees::Place> solids = trees_.open(proto.solids, around);
    uint32_t opened = index;
    if (within != FlatScene::kWorld) {
      opened = uint32_t(scene_.instances.size() + flat_->opened_.size());
      flat_->opened_.push_back({within, index, prototype});
    }
    bool isPlain = proto.solids.empty() && around.solid == trace::kNoSolid;  // the next one will be like this one
    if (isPlain && proto.instances.empty())
      if (const auto it = plain_.find({prototype, attributes.get()}); it != plain_.end()) {
        for (const auto& [kind, primitive] : it->second) {
          ++placed_;
          placeKind(kind, opened, primitive, around);
        }
        return;
      }
    std::vector<std::pair<uint32_t, uint32_t>> kinds;  // and primitives
    std::vector<Given> many, alone;
    const bool mayBeMany = isPlain && proto.primitives.size() > 1;
    for (uint32_t k = 0; k < proto.primitives.size(); ++k) {
      const scene::PrimitivePtr& p = proto.primitives[k];
      isPlain &= !hasDetail(p->attributes.get());
      if (!isSeen(p->attributes.get(), opened)) continue;
      const SolidTrees::Place in = placeIn(solids, p->solid, around, [&] { return p->pos; });
      const auto& [inherited, lookAsSaid] = inheritedBy(p->attributes, attributes);
      const bool isTurned = trees_.isTurned(in);
      const scene::AttributesPtr& given = isTurned ? turned(inherited) : inherited;
      const Digest look = isTurned ? lookOf(given.get()) : lookAsSaid;
      const bool isOfMany =
          mayBeMany && !boundsMedia(inherited.get()) && !hasDetail(p->attributes.get()) && maySharePart(*p);
      (isOfMany ? many : alone).push_back({k, given, inherited.get(), look, in});
    }
    const uint32_t kind = kindsOfMany(prototype, attributes.get(), many);
    if (kind != kNone) {
      ++placed_;
      placeKind(kind, opened, FlatScene::kMany, around);
      kinds.emplace_back(kind, FlatScene::kMany);
    } else {
      alone.insert(alone.end(), many.begin(), many.end());
      std::sort(alone.begin(), alone.end(), [](const Given& a, const Given& b) { return a.primitive < b.primitive; });
    }
    for (const Given& g : alone) {
      const auto [it, isNew] = partOf_.try_emplace({prototype, g.primitive, g.look}, 0);
      if (isNew)
        it->second = addPart((uint64_t(prototype) + 1) << 32 | g.primitive, true,
                             {proto.primitives[g.primitive], g.attributes, g.look});
      ++placed_;
      place(it->second, opened, g.primitive, g.inherited, g.in);
      kinds.emplace_back(flat_->placements.back().kind, g.primitive);
    }
    if (isPlain && proto.instances.empty()) {
      if (plain_.size() == kMostPlain) plain_.clear();
      plain_[{prototype, attributes.get()}] = std::move(kinds);
    }
    openAll(proto.instances, opened, depth + 1, &attributes, solids, around);
  }

  // Those of a list that stands in an opened one, whose attributes are `outer`; null: in the world.
  void openAll(const scene::InstanceList& list, uint32_t within, int depth, const scene::AttributesPtr* outer,
               const std::vector<SolidTrees::Place>& solids, const SolidTrees::Place& around) {
    for (uint32_t k = 0; k < list.size() && !isTooMany_; ++k) {
      const scene::AttributesPtr& own = list.attributesOf(k);
      if (!isSeen(own.get(), within)) continue;
      open(list, k, within, depth, outer ? inheritedBy(own, *outer).first : own,
           placeIn(solids, list.solidOf(k), around, [&] { return list[k].pos; }));
    }
  }

  static constexpr uint32_t kNone = ~0u;
  const scene::Scene& scene_;
  const std::function<bool(const scene::Attributes*)>& boundsMedia_;
  const scene::Network* lastMaterial_ = nullptr;
  bool lastBoundsMedia_ = false;
  const std::atomic<bool>* stop_;
  Diagnostics& diagnostics_;
  std::shared_ptr<FlatScene> flat_;
  std::shared_ptr<std::vector<shade::ObjectSpace>> spaces_ = std::make_shared<std::vector<shade::ObjectSpace>>();
  std::map<std::tuple<uint32_t, uint32_t, Digest>, uint32_t> partOf_;
  SolidTrees trees_;
  std::map<scene::AttributesPtr, scene::AttributesPtr> turned_;
  std::map<std::pair<uint32_t, const scene::Attributes*>, uint32_t> kinds_;
  const float relativeDetail_ = scene_.options.getFloat("detail:relative", 1);
  const scene::Attributes* lastWithout_ = nullptr;  // that say nothing of levels of detail
  // what follows from attributes that many share
  const scene::Attributes* lastAttributes_ = nullptr;
  uint32_t lastVisibility_ = 0;
  shade::PlacementInfo lastInfo_;
  std::pair<const scene::Attributes*, Digest> lastLook_;
  bool isLookKnown_ = false;
  // Kinds and primitives that instances place of an object with these attributes, where nothing else decides that.
  static constexpr size_t kMostPlain = 4096;
  std::map<std::pair<uint32_t, const scene::Attributes*>, std::vector<std::pair<uint32_t, uint32_t>>> plain_;
  uint64_t placed_ = 0, opened_ = 0;
  bool isTooMany_ = false, isTooDeep_ = false;
};

std::shared_ptr<const FlatScene> flatten(const scene::Scene& scene, const RenderSpace& space,
                                         const std::set<uint32_t>& leaveOut,
                                         const std::function<bool(const scene::Attributes*)>& boundsMedia,
                                         const std::atomic<bool>* stop, Diagnostics& diagnostics) {
  return Flattener(scene, space, leaveOut, boundsMedia, stop, diagnostics).run();
}

}  // namespace kinora::render
