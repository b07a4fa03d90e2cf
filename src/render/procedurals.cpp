#include "render/procedurals.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <unordered_map>
#include <utility>

#include "render/detail.h"
#include "scene/swept_box.h"

namespace kinora::render {

namespace {

// Ids of what archives hold: those of a description count from 1 and are fewer, media have a bit of their own.
constexpr uint32_t kFirstId = 0x20000000, kOfExpansion = 0x40000000;

bool holdsDetail(const scene::Expansion& e) {
  for (const scene::PrimitivePtr& p : e.primitives)
    if (hasDetail(p->attributes.get())) return true;
  for (size_t k = 0; k < e.instances.size(); ++k)
    if (hasDetail(e.instances.attributesOf(k).get())) return true;
  return false;
}

uint64_t idsIn(const scene::Expansion& e) {
  uint64_t n = e.primitives.size();
  for (const scene::Prototype& p : e.prototypes) n += p.primitives.size();
  return n;
}

}  // namespace

void Procedurals::setSources(std::shared_ptr<const scene::ProceduralSources> sources) {
  sources_ = std::move(sources);
  roots_.clear();
  total_ = readCount_ = 0;
}

void Procedurals::forget() {
  roots_.clear();
  total_ = readCount_ = 0;
}

std::unique_ptr<Procedurals::Node> Procedurals::nodeOf(const scene::PrimitivePtr& primitive,
                                                       std::shared_ptr<const scene::ProceduralSource> source) {
  const std::optional<Imath::Box3d> own = source ? scene::boundOf(*primitive) : std::nullopt;
  if (!own) return nullptr;
  auto n = std::make_unique<Node>();
  n->primitive = primitive;
  n->source = std::move(source);
  n->said = scene::sweptBox(*own, primitive->toWorld);
  // files round bounds to a few digits
  const Imath::V3d size = own->size();
  const Imath::V3d more(2 * kRounded * std::max({size.x, size.y, size.z}));
  n->bound = scene::sweptBox({own->min - more, own->max + more}, primitive->toWorld);
  return n;
}

void Procedurals::begin(const scene::Scene& said) {
  said_ = &said;
  nextId_ = std::max(nextId_, kFirstId);
  std::unordered_map<const scene::Primitive*, std::unique_ptr<Node>> before;
  for (auto& n : roots_) before.emplace(n->primitive.get(), std::move(n));
  roots_.clear();
  if (sources_)
    for (const scene::PrimitivePtr& p : said.primitives) {
      const auto it = sources_->find(p->id);
      if (it == sources_->end()) continue;
      auto& known = before[p.get()];
      if (!known && (known = nodeOf(p, it->second))) ++total_;
      if (known) roots_.push_back(std::move(known));
    }
  if (!roots_.empty()) assemble();
}

// The scene as it is said, without the primitives that stand for procedurals, then what was read of them.
void Procedurals::assemble() {
  std::vector<scene::PrimitivePtr> primitives;
  size_t next = 0;
  for (const scene::PrimitivePtr& p : said_->primitives)
    if (next < roots_.size() && roots_[next]->primitive == p)
      ++next;
    else
      primitives.push_back(p);
  scene_ = *said_;
  scene_.primitives = std::move(primitives);
  delayed_ = {};
  delayed_.firstInstance = uint32_t(scene_.instances.size());
  unread_.clear();
  lastRead_.clear();
  for (const auto& n : roots_) {
    delayed_.all.push_back({n->bound, n->primitive->attributes});
    add(*n);
  }
}

void Procedurals::add(Node& n) {
  if (!n.isRead) {
    delayed_.unread.push_back({n.bound, n.primitive->attributes});
    unread_.push_back(&n);
    return;
  }
  if (std::exchange(n.isNew, false))
    lastRead_.push_back({uint32_t(scene_.instances.size()), n.primitive.get(), n.said});
  if (!n.whole.primitives.empty() || !n.whole.instances.empty()) {
    const auto first = uint32_t(scene_.prototypes.size());
    const auto renumbered = [&](const scene::InstanceList& list) {
      if (first == 0 || list.empty()) return list;
      scene::InstanceList out;
      for (size_t k = 0; k < list.size(); ++k) {
        scene::Instance i = list[k];
        i.prototype += first;
        out.push_back(std::move(i));
      }
      return out;
    };
    for (scene::Prototype p : n.objects) {
      p.instances = renumbered(p.instances);
      scene_.prototypes.push_back(std::move(p));
    }
    scene::Prototype whole = n.whole;
    whole.instances = renumbered(whole.instances);
    scene_.prototypes.push_back(std::move(whole));
    scene::Instance place;
    place.prototype = uint32_t(scene_.prototypes.size() - 1);
    place.toWorld = scene::Transform::fixed(scene::Matrix().setTranslation(n.middle));
    place.pos = n.primitive->pos;
    scene_.instances.push_back(std::move(place));
  } else if (!lastRead_.empty() && lastRead_.back().procedural == n.primitive.get()) {
    lastRead_.pop_back();
  }
  for (const auto& inner : n.nested) add(*inner);
}

// Its space is the world's, moved to the middle of the bound, where floats are fine. Boxes of levels of detail are said
// in the world's: what has some stays there.
void Procedurals::take(Node& n, scene::Expansion e, uint32_t nextId) {
  if (!holdsDetail(e)) n.middle = n.bound.center();
  const scene::Transform shift = scene::Transform::fixed(scene::Matrix().setTranslation(-n.middle));
  n.whole.name = n.primitive->name();
  n.whole.pos = n.primitive->pos;
  for (scene::PrimitivePtr& p : e.primitives) {
    auto own = std::make_shared<scene::Primitive>(*p);
    p = nullptr;
    const auto source = e.nested.find(own->id);
    own->id = nextId++;
    if (source != e.nested.end()) {
      if (auto inner = nodeOf(own, source->second)) n.nested.push_back(std::move(inner));
      continue;
    }
    own->toWorld = concat(own->toWorld, shift);
    n.whole.primitives.push_back(std::move(own));
  }
  for (size_t k = 0; k < e.instances.size(); ++k) {
    scene::Instance i = e.instances[k];
    i.toWorld = concat(i.toWorld, shift);
    n.whole.instances.push_back(std::move(i));
  }
  n.whole.solids = std::move(e.solids);
  n.objects = std::move(e.prototypes);
  // objects that were said outside keep their ids
  for (scene::Prototype& object : n.objects)
    for (scene::PrimitivePtr& p : object.primitives) {
      if (p->id < kOfExpansion) continue;
      auto own = std::make_shared<scene::Primitive>(*p);
      own->id = nextId++;
      p = std::move(own);
    }
  n.isRead = n.isNew = true;
}

void Procedurals::read(const std::vector<uint32_t>& which, FileContents& contents, Diagnostics& diagnostics,
                       const std::atomic<bool>* stop) {
  std::vector<Node*> nodes;
  for (const uint32_t k : which) nodes.push_back(unread_[k]);
  std::vector<scene::Expansion> read(nodes.size());
  std::vector<std::unique_ptr<Diagnostics>> said(nodes.size());
  tbb::parallel_for(size_t(0), nodes.size(), [&](size_t i) {
    if (stop && stop->load(std::memory_order_relaxed)) return;
    said[i] = std::make_unique<Diagnostics>([](const std::string&, Severity) {});
    read[i] = nodes[i]->source->expand(*nodes[i]->primitive, *said[i]);
  });
  if (stop && stop->load()) return;
  std::vector<uint32_t> firstId(nodes.size());
  for (size_t i = 0; i < nodes.size(); ++i) {
    for (Message& m : said[i]->messages()) diagnostics.report(std::move(m));
    for (const auto& [name, path] : read[i].files) contents.use("archive", name, {path});
    firstId[i] = nextId_;
    nextId_ += uint32_t(idsIn(read[i]));
  }
  tbb::parallel_for(size_t(0), nodes.size(), [&](size_t i) { take(*nodes[i], std::move(read[i]), firstId[i]); });
  for (const Node* n : nodes) total_ += n->nested.size();
  readCount_ += nodes.size();
  assemble();
}

}  // namespace kinora::render
