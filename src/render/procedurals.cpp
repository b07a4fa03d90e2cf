#include "render/procedurals.h"

#include <tbb/parallel_for.h>

#include <sys/stat.h>

#include <algorithm>
#include <functional>
#include <unordered_map>
#include <utility>

#include "render/detail.h"
#include "scene/bytes.h"
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

// Times and sizes of files.
std::vector<int64_t> stampsOf(const std::vector<std::pair<std::string, std::string>>& files) {
  std::vector<int64_t> stamps;
  for (const auto& [name, path] : files) {
    struct stat s {};
    const bool isThere = stat(path.c_str(), &s) == 0;
    for (const int64_t v : {int64_t(s.st_mtim.tv_sec), int64_t(s.st_mtim.tv_nsec), int64_t(s.st_size)})
      stamps.push_back(isThere ? v : -1);
  }
  return stamps;
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
  nodes_.clear();
  held_.clear();
  told_.clear();
  counts_ = {};
}

bool Procedurals::describe(Node& n, const scene::PrimitivePtr& primitive,
                           std::shared_ptr<const scene::ProceduralSource> source) {
  const std::optional<Imath::Box3d> own = source ? scene::boundOf(*primitive) : std::nullopt;
  if (!own) return false;
  n.primitive = primitive;
  n.source = std::move(source);
  n.said = scene::sweptBox(*own, primitive->toWorld);
  // files round bounds to a few digits
  const Imath::V3d size = own->size();
  const Imath::V3d more(2 * kRounded * std::max({size.x, size.y, size.z}));
  n.bound = scene::sweptBox({own->min - more, own->max + more}, primitive->toWorld);
  return true;
}

void Procedurals::enter(Node& n, uint32_t inside) {
  n.number = uint32_t(nodes_.size());
  nodes_.push_back(&n);
  held_.emplace_back().inside = inside;
}

void Procedurals::leave(Node& n) {
  for (const auto& inner : n.nested) leave(*inner);
  if (n.number == HeldProcedural::kNone) return;
  nodes_[n.number] = nullptr;
  held_[n.number] = {};
}

void Procedurals::release(Node& n) {
  for (const auto& inner : n.nested) {
    release(*inner);
    inner->source = nullptr;  // it holds what was said around it
    inner->primitive = nullptr;
  }
  n.whole = {};
  n.objects.clear();
  n.isNew = n.isAside = false;
  if (n.number != HeldProcedural::kNone) held_[n.number].isHeld = false;
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
      if (!known) {
        auto made = std::make_unique<Node>();
        if (!describe(*made, p, it->second)) continue;
        enter(*made, HeldProcedural::kNone);
        known = std::move(made);
      }
      roots_.push_back(std::move(known));
    }
  for (const auto& [primitive, gone] : before)
    if (gone) leave(*gone);
  counts_ = {};
  told_.clear();
  for (const auto& n : roots_) {
    setAside(*n);
    ++counts_.met;
  }
  if (!roots_.empty()) assemble();
}

void Procedurals::setAside(Node& n) {
  for (const auto& inner : n.nested) setAside(*inner);
  if (n.number == HeldProcedural::kNone) return;
  // what could not be read may be there now
  if (isHeld(n) && (n.contents.empty() || stampsOf(n.files) != n.stamps)) release(n);
  n.isAside = isHeld(n);
  n.cells = nullptr;  // what is placed and diced by the camera may be elsewhere
  n.wasRead = false;
  held_[n.number].isHeld = false;
}

bool Procedurals::resume(FileContents& contents) {
  for (uint32_t k = 0; k < nodes_.size(); ++k) {  // what others are inside of has a smaller number
    if (!nodes_[k] || !nodes_[k]->source) continue;
    Node& n = *nodes_[k];
    const uint32_t inside = held_[k].inside;
    if (inside != HeldProcedural::kNone) {
      if (!held_[inside].isHeld) {
        release(n);
        continue;
      }
      ++counts_.met;
    }
    if (!std::exchange(n.isAside, false)) continue;
    held_[k].isHeld = n.wasRead = true;
    ++counts_.read;
    for (const auto& [name, path] : n.files) contents.use("archive", name, {path});
  }
  if (counts_.read == 0) return false;
  countBytes();
  assemble();
  return true;
}

void Procedurals::countBytes() {
  counts_.bytes = counts_.largest = 0;
  for (uint32_t k = 0; k < held_.size(); ++k) {
    if (nodes_[k] && nodes_[k]->wasRead) counts_.largest = std::max(counts_.largest, held_[k].bytes);
    if (held_[k].isHeld) counts_.bytes += held_[k].bytes;
  }
  counts_.mostBytes = std::max(counts_.mostBytes, counts_.bytes + leaving_);
}

void Procedurals::setBytes(uint32_t number, uint64_t bytes) {
  held_[number].bytes = nodes_[number]->descriptionBytes + bytes;
}

void Procedurals::setCells(uint32_t number, std::vector<Imath::Box3d> cells) {
  Node& n = *nodes_[number];
  if (!n.nested.empty()) return;  // what is in these is not known while it is not held
  n.cells = std::make_shared<const std::vector<Imath::Box3d>>(std::move(cells));
}

void Procedurals::expectSizes(const std::vector<uint32_t>& which) {
  uint64_t files = 0, ofFiles = 0, all = 0, count = 0;
  for (uint32_t k = 0; k < nodes_.size(); ++k) {
    if (!nodes_[k] || !nodes_[k]->wasRead) continue;
    all += held_[k].bytes;
    ++count;
    if (!nodes_[k]->fileBytes) continue;
    files += nodes_[k]->fileBytes;
    ofFiles += held_[k].bytes;
  }
  for (const uint32_t k : which) {
    if (!nodes_[k]) continue;
    Node& n = *nodes_[k];
    const uint32_t inside = held_[k].inside;
    if (!n.source && inside != HeldProcedural::kNone && held_[inside].isHeld) held_[k].bytes = 0;  // said no more
    if (n.wasRead || !n.source) continue;
    if (!n.fileBytes) n.fileBytes = n.source->bytesToRead();
    constexpr uint64_t kUsual = 1 << 20, kOfByte = 8;  // before anything is known
    held_[k].bytes = !n.fileBytes ? (count ? all / count : kUsual)
                     : files      ? uint64_t(double(n.fileBytes) * double(ofFiles) / double(files))
                                  : n.fileBytes * kOfByte;
  }
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
  std::vector<Node*> held;
  const std::function<void(Node&)> look = [&](Node& n) {
    if (!n.source) return;
    if (!isHeld(n)) {
      delayed_.unread.push_back({n.bound, n.primitive->attributes, n.cells});
      unread_.push_back(&n);
      return;
    }
    held.push_back(&n);
    for (const auto& inner : n.nested) look(*inner);
  };
  for (const auto& n : roots_) {
    delayed_.all.push_back({n->bound, n->primitive->attributes});
    look(*n);
  }
  // Those that were read first stand first: what is kept of paths between stages names things of the world by their
  // places, which must not move while more is read.
  std::sort(held.begin(), held.end(), [](const Node* a, const Node* b) {
    return a->firstId != b->firstId ? a->firstId < b->firstId : a->number < b->number;
  });
  for (Node* n : held) add(*n);
}

// Of what is held.
void Procedurals::add(Node& n) {
  if (n.isNew)
    lastRead_.push_back({uint32_t(scene_.instances.size()), n.number, n.primitive.get(), n.said, n.wasRead});
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
}

// Its space is the world's, moved to the middle of the bound, where floats are fine. Boxes of levels of detail are said
// in the world's: what has some stays there.
void Procedurals::take(Node& n, scene::Expansion e, uint32_t nextId) {
  n.middle = holdsDetail(e) ? Imath::V3d(0) : n.bound.center();
  const scene::Transform shift = scene::Transform::fixed(scene::Matrix().setTranslation(-n.middle));
  n.whole = {};
  n.whole.name = n.primitive->name();
  n.whole.pos = n.primitive->pos;
  size_t nested = 0;  // they keep their numbers from one reading to the next
  for (scene::PrimitivePtr& p : e.primitives) {
    auto own = std::make_shared<scene::Primitive>(*p);
    p = nullptr;
    const auto source = e.nested.find(own->id);
    own->id = nextId++;
    if (source != e.nested.end()) {
      if (nested == n.nested.size()) n.nested.push_back(std::make_unique<Node>());
      if (describe(*n.nested[nested], own, source->second)) ++nested;
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
  n.descriptionBytes = sizeof n + n.whole.instances.size() * sizeof(scene::Instance);
  for (const scene::PrimitivePtr& p : n.whole.primitives) n.descriptionBytes += scene::bytesHeld(*p);
  // objects that were said outside keep their ids
  for (scene::Prototype& object : n.objects)
    for (scene::PrimitivePtr& p : object.primitives) {
      if (p->id < kOfExpansion) continue;
      auto own = std::make_shared<scene::Primitive>(*p);
      own->id = nextId++;
      p = std::move(own);
      n.descriptionBytes += scene::bytesHeld(*p);
    }
  n.files = std::move(e.files);
  n.contents = std::move(e.contents);
  n.stamps = stampsOf(n.files);
  n.isNew = true;
}

void Procedurals::tellOfChange(const Node& n, const Contents& now, Diagnostics& diagnostics) {
  const auto tell = [&](const std::string& what, const char* how) {
    if (!told_.insert(what).second) return;
    diagnostics.warning("RENDER-PROCEDURAL-CHANGED", n.primitive->pos,
                        "'" + what.substr(0, 200) + "' " + how +
                            " since it was first read for this frame, and was dropped meanwhile to save memory",
                        "what it gives now is used from here on, beside samples that saw what it gave before",
                        "render again with files that stay as they are, or with a larger --geometry-cache");
  };
  for (const auto& [what, content] : n.contents) {
    const auto is = std::find_if(now.begin(), now.end(), [&](const auto& c) { return c.first == what; });
    if (is == now.end())
      tell(what, "is not read any more");
    else if (is->second != content)
      tell(what, "has changed");
  }
  for (const auto& [what, content] : now)
    if (std::none_of(n.contents.begin(), n.contents.end(), [&](const auto& c) { return c.first == what; }))
      tell(what, "was not read before: what reads it has changed");
}

void Procedurals::read(const std::vector<uint32_t>& which, FileContents& contents, Diagnostics& diagnostics,
                       const std::atomic<bool>* stop) {
  std::vector<Node*> nodes;
  for (const uint32_t k : which)
    if (nodes_[k] && nodes_[k]->source && !held_[k].isHeld) nodes.push_back(nodes_[k]);
  std::vector<scene::Expansion> read(nodes.size());
  std::vector<std::unique_ptr<Diagnostics>> said(nodes.size());
  tbb::parallel_for(size_t(0), nodes.size(), [&](size_t i) {
    if (stop && stop->load(std::memory_order_relaxed)) return;
    said[i] = std::make_unique<Diagnostics>([](const std::string&, Severity) {});
    read[i] = nodes[i]->source->expand(*nodes[i]->primitive, *said[i], nodes[i]->wasRead);
  });
  if (stop && stop->load()) return;
  std::vector<uint32_t> firstId(nodes.size());
  for (size_t i = 0; i < nodes.size(); ++i) {
    Node& n = *nodes[i];
    // what stays as it was has been said
    if (!n.wasRead || read[i].contents != n.contents)
      for (Message& m : said[i]->messages()) diagnostics.report(std::move(m));
    if (n.wasRead) tellOfChange(n, read[i].contents, diagnostics);
    if (!n.nested.empty() || !read[i].nested.empty() || read[i].contents != n.contents) n.cells = nullptr;
    for (const auto& [name, path] : read[i].files) contents.use("archive", name, {path});
    const uint64_t ids = idsIn(read[i]);
    if (!n.firstId || ids > n.ids) {
      n.firstId = nextId_;
      nextId_ += uint32_t(ids);
      n.ids = ids;
    }
    firstId[i] = n.firstId;
    ++(n.wasRead ? counts_.again : counts_.read);
  }
  tbb::parallel_for(size_t(0), nodes.size(), [&](size_t i) { take(*nodes[i], std::move(read[i]), firstId[i]); });
  for (Node* n : nodes) {
    held_[n->number].isHeld = true;
    held_[n->number].bytes = n->descriptionBytes;
    for (const auto& inner : n->nested) {
      if (inner->number != HeldProcedural::kNone || !inner->source) continue;
      enter(*inner, n->number);
      ++counts_.met;
    }
  }
  assemble();
}

void Procedurals::settle() {
  for (Node* n : nodes_)
    if (n && std::exchange(n->isNew, false)) n->wasRead = true;
  lastRead_.clear();
  countBytes();
  leaving_ = 0;
}

void Procedurals::drop(const std::vector<uint32_t>& which) {
  for (const uint32_t k : which) {
    if (!held_[k].isHeld) continue;
    leaving_ += held_[k].bytes;
    release(*nodes_[k]);
    ++counts_.dropped;
  }
  assemble();
}

}  // namespace kinora::render
