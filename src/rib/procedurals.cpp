// Procedurals that are read later: what their requests leave in the description, and how they are read when somebody
// asks (scene/procedural.h).
#include <algorithm>
#include <filesystem>
#include <map>
#include <optional>
#include <utility>

#include "base/file_contents.h"
#include "rib/byte_source.h"
#include "rib/interpreter.h"
#include "scene/digests.h"

namespace kinora::rib {

namespace {

scene::Parameter argument(const char* name, const SourcePos& pos) {
  scene::Parameter p;
  p.name = name;
  p.isArray = true;
  p.storage = scene::StorageClass::Constant;
  p.pos = pos;
  return p;
}

Digest digestOfRequests(const std::vector<Request>& requests) {
  Hasher h;
  for (const Request& r : requests) {
    h.text(r.name);
    h.word(r.count);
    for (size_t i = 0; i < r.count; ++i) {
      const Argument& a = r.args[i];
      h.word(uint64_t(a.kind) | uint64_t(a.isArray) << 8 | uint64_t(a.isInteger) << 9);
      h.bytes(a.ints.data(), a.ints.size() * sizeof(int));
      h.bytes(a.floats.data(), a.floats.size() * sizeof(float));
      h.word(a.strings.size());
      for (const std::string& s : a.strings) h.text(s);
    }
  }
  return h.result();
}

// The objects that instances name, and those that these name, with places that count from 0.
std::vector<scene::Prototype> objectsOf(scene::InstanceList& instances, std::vector<scene::Prototype> own,
                                        size_t ownFrom, const std::vector<scene::Prototype>* outer) {
  constexpr uint32_t kNone = ~0u;
  std::vector<uint32_t> placeOf(own.size(), kNone);
  std::vector<scene::Prototype> out;
  const auto take = [&](uint32_t object) {
    if (placeOf[object] != kNone) return;
    placeOf[object] = uint32_t(out.size());
    out.push_back(object >= ownFrom ? std::move(own[object]) : (*outer)[object]);
  };
  for (size_t k = 0; k < instances.size(); ++k) take(instances.prototypeOf(k));
  for (size_t i = 0; i < out.size(); ++i)
    for (size_t k = 0; k < std::as_const(out)[i].instances.size(); ++k) take(out[i].instances.prototypeOf(k));
  const auto renumber = [&](scene::InstanceList& list) {
    scene::InstanceList numbered;
    for (size_t k = 0; k < list.size(); ++k) {
      scene::Instance i = list[k];
      i.prototype = placeOf[i.prototype];
      numbered.push_back(std::move(i));
    }
    list = std::move(numbered);
  };
  renumber(instances);
  for (scene::Prototype& p : out) renumber(p.instances);
  return out;
}

}  // namespace

class Interpreter::DelayedArchive final : public scene::ProceduralSource {
 public:
  DelayedArchive(std::shared_ptr<const Surroundings> surroundings, const State& state, Delayed what,
                 const SourcePos& pos)
      : around_(std::move(surroundings)), state_(state), what_(std::move(what)), pos_(pos) {}

  std::vector<std::shared_ptr<const NodeMap>> nodes;  // from the outermost on
  std::vector<std::string> ancestors;

  scene::Expansion expand(const scene::Primitive& as, Diagnostics& diagnostics, bool isAgain) const override {
    std::optional<scene::Scene> world;
    Interpreter in(diagnostics, around_->read, [&](scene::Scene&& s) {
      if (!world) world = std::move(s);
    });
    prepare(in, as);
    if (around_->prototypes->size() >= around_->prototypeCount) {
      in.outerPrototypes_ = around_->prototypes.get();
      in.outerPrototypeCount_ = around_->prototypeCount;
    }
    if (isAgain) in.archiveReads_ = std::make_shared<std::atomic<int>>(0);
    read(in);
    const auto shared = in.worldPrototypes_;  // those that what is nested here will ask for
    while (!in.blocks_.empty()) in.leave();
    for (size_t k = 0; shared && k < around_->prototypeCount; ++k) (*shared)[k] = (*around_->prototypes)[k];

    scene::Expansion out;
    // folders may hold files of one name: each is known by those that lead to it
    std::string way;
    for (size_t k = 1; k < ancestors.size(); ++k)
      way += std::filesystem::path(ancestors[k]).filename().string() + " > ";
    out.files = std::move(in.filesRead_);
    out.contents = std::move(in.programsRun_);
    for (auto& [name, path] : out.files) {
      name = way + name;
      out.contents.emplace_back(path, digestOfFile(path).value_or(Digest()));
    }
    if (!world) return out;
    out.primitives = std::move(world->primitives);
    out.instances = std::move(world->instances);
    out.solids = std::move(world->solids);
    out.prototypes =
        objectsOf(out.instances, std::move(in.prototypes_), around_->prototypeCount, around_->prototypes.get());
    leaveOutLights(in, *world, out.prototypes);
    if (in.doneProcedurals_) out.nested = *in.doneProcedurals_;
    return out;
  }

  uint64_t bytesToRead() const override {
    if (what_.isProgram()) return 0;
    Diagnostics unheard([](const std::string&, Severity) {});
    Interpreter in(unheard, around_->read, {});
    in.frame_.options = around_->world;
    in.mainDirectory_ = around_->mainDirectory;
    in.dirmap_ = around_->dirmap;
    std::error_code failed;
    const auto size =
        std::filesystem::file_size(in.findArchive(what_.data[0], pos_.file ? *pos_.file : std::string()), failed);
    return failed ? 0 : size;
  }

  // With nothing kept of what it says. Programs are not run for that.
  bool saysLights(const Interpreter& of, const scene::Primitive& as) const {
    Diagnostics unheard([](const std::string&, Severity) {});  // it says it all once it is read for itself
    ReadOptions options = around_->read;
    options.checkOnly = true;
    options.allowExec = false;
    Interpreter in(unheard, options, {});
    prepare(in, as);
    in.archiveReads_ = std::make_shared<std::atomic<int>>(0);
    in.lightSearch_ = of.lightSearch_;
    in.lightingObjects_ = of.lightingObjects_;
    in.onlyLooks_ = true;
    read(in);
    return in.saysLights_;
  }

  // Its objects, and those of what is nested in it, become those of `to`. Programs are not run for that.
  void giveObjects(Interpreter& to, const scene::Primitive& as) const {
    if (what_.isProgram()) return;
    Diagnostics unheard([](const std::string&, Severity) {});  // it says it all once it is read for itself
    Interpreter in(unheard, around_->read, {});
    prepare(in, as);
    const size_t count = around_->prototypeCount;
    in.outer_ = &to;
    in.outerPrototypeCount_ = count;
    read(in);
    in.findInDelayed({});
    const auto first = uint32_t(to.prototypes_.size());
    for (size_t k = count; k < in.prototypes_.size(); ++k) {
      scene::Prototype p = std::move(in.prototypes_[k]);
      for (scene::PrimitivePtr& shared : p.primitives) {
        auto own = std::make_shared<scene::Primitive>(*shared);
        own->id = to.nextId_++;
        const bool choseFaces = in.ownFaceSets_.contains(shared);
        shared = std::move(own);
        if (choseFaces) to.ownFaceSets_.insert(shared);
      }
      scene::InstanceList instances;
      for (size_t i = 0; i < p.instances.size(); ++i) {
        scene::Instance placed = std::as_const(p.instances)[i];
        placed.id = to.nextId_++;
        if (placed.prototype >= count) placed.prototype = first + (placed.prototype - uint32_t(count));
        instances.push_back(std::move(placed));
      }
      p.instances = std::move(instances);
      to.prototypes_.push_back(std::move(p));
    }
    for (const auto& [name, index] : in.prototypeByHandle_)
      if (index >= count) to.prototypeByHandle_.try_emplace(name, first + (index - uint32_t(count)));
    to.surroundings_ = nullptr;
  }

 private:
  // Those of objects that it places too, its own and the world's: they would shine from when a ray came by.
  void leaveOutLights(Interpreter& in, const scene::Scene& world, std::vector<scene::Prototype>& objects) const {
    size_t lights = world.lights.size() + world.classicLights.size();
    const scene::Light* first = !world.lights.empty()          ? &world.lights[0]
                                : !world.classicLights.empty() ? &world.classicLights[0]
                                                               : nullptr;
    for (const scene::Prototype& o : objects) {
      if (!first && !o.lights.empty()) first = &o.lights[0];
      lights += o.lights.size();
    }
    if (lights == 0) return;
    in.report(Severity::Error, "RIB-PROCEDURAL-LIGHT", first->node->pos,
              "'" + what_.data[0].substr(0, 200) + "' says " + std::to_string(lights) +
                  (lights == 1 ? " light" : " lights") +
                  ", or places objects with them, once a ray has reached its bound",
              "they are left out: which lights there are is known before the first ray",
              "an archive in place of a program, or Attribute \"procedural\" \"int immediatesubdivide\" [1] before "
              "it, reads it at once");
    for (scene::Prototype& o : objects) o.lights.clear();
  }

  void read(Interpreter& in) const {
    Request request;
    request.name = "Procedural";
    request.pos = pos_;
    if (what_.isProgram())
      in.readProgram(what_, request);
    else
      in.readNamedArchive(what_.data[0], request);
    in.sources_.clear();
    in.closeAll(1);
  }

  void prepare(Interpreter& in, const scene::Primitive& as) const {
    const Surroundings& from = *around_;
    in.declarations_ = from.declarations;
    in.frame_ = from.frame;
    in.materials_ = from.materials;
    in.resources_ = from.resources;
    in.lightSourceOf_ = from.lightSourceOf;
    in.prototypeByHandle_ = from.prototypeByHandle;
    in.ownFaceSets_ = from.ownFaceSets;
    in.inlineArchives_ = from.inlineArchives;
    in.dirmap_ = from.dirmap;
    in.mainDirectory_ = from.mainDirectory;
    in.marker_ = from.marker;
    in.bareMarker_ = from.bareMarker;
    in.prototypes_.resize(from.prototypeCount);  // theirs are seen where they are: prototypeAt()
    in.archiveReads_ = from.archiveReads;
    in.ancestors_ = ancestors;
    in.state_ = state_;
    in.state_.ctm = as.toWorld;
    in.state_.attributes = std::make_shared<scene::Attributes>(*as.attributes);
    in.lightSearch_ = nullptr;  // whoever asked for it has looked
    in.nextId_ = 0x40000000;    // lights of it are nobody's, and not those outside of its attributes
    Block block{};
    block.kind = BlockKind::World;
    block.pos = pos_;
    block.state = std::make_unique<State>(in.state_);
    block.nodes = std::make_shared<NodeMap>();
    for (const auto& map : nodes)
      for (const auto& [handle, node] : *map) (*block.nodes)[handle] = node;
    in.blocks_.push_back(std::move(block));
    in.world_ = from.world;
    in.onlyScoped_ = from.onlyScoped;
  }

  std::shared_ptr<const Surroundings> around_;
  State state_;
  Delayed what_;
  SourcePos pos_;
};

std::shared_ptr<const Interpreter::Surroundings> Interpreter::surroundings() {
  if (surroundings_) return surroundings_;
  if (!worldPrototypes_) worldPrototypes_ = std::make_shared<std::vector<scene::Prototype>>();
  auto s = std::make_shared<Surroundings>();
  s->read = read_;
  s->declarations = declarations_;
  s->frame = frame_;
  s->world = frame_.options;
  s->world.options = world_->options;
  s->world.cameras = world_->cameras;
  s->world.coordinateSystems = world_->coordinateSystems;
  s->onlyScoped = onlyScoped_;
  s->materials = materials_;
  s->resources = resources_;
  s->lightSourceOf = lightSourceOf_;
  s->prototypeByHandle = prototypeByHandle_;
  s->ownFaceSets = ownFaceSets_;
  s->inlineArchives = inlineArchives_;
  s->dirmap = dirmap_;
  s->mainDirectory = mainDirectory_;
  s->marker = marker_;
  s->bareMarker = bareMarker_;
  s->prototypeCount = prototypes_.size();
  s->prototypes = worldPrototypes_;
  s->archiveReads = archiveReads_;
  Hasher said;
  for (const auto& [name, requests] : std::map(inlineArchives_.begin(), inlineArchives_.end())) {
    said.text(name);
    said.digest(digestOfRequests(*requests));
  }
  s->said = said.result();
  return surroundings_ = std::move(s);
}

const Digest& Interpreter::digestOf(const std::shared_ptr<NodeMap>& nodes) {
  const auto [it, isNew] = nodeDigests_.try_emplace(nodes.get(), nodes, Digest());
  if (!isNew) return it->second.second;
  Hasher h;
  for (const auto& [handle, node] : std::map(nodes->begin(), nodes->end())) {
    h.text(handle);
    h.digest(scene::digestOf(node));
  }
  return it->second.second = h.result();
}

bool Interpreter::findInDelayed(const std::string& handle) {
  if (!world_ || !procedurals_) return false;
  while (lookedInto_ < world_->primitives.size()) {
    const scene::PrimitivePtr p = world_->primitives[lookedInto_++];
    const auto it = procedurals_->find(p->id);
    if (it == procedurals_->end()) continue;
    static_cast<const DelayedArchive&>(*it->second).giveObjects(*this, *p);
    if (prototypeByHandle_.contains(handle)) return true;
  }
  return false;
}

bool Interpreter::holdsLights(const DelayedArchive& archive, const scene::Primitive& as, const std::string& name,
                              const Request& r) {
  const std::string file = findArchive(name, r.pos.file ? *r.pos.file : std::string());
  if (file.empty()) return false;  // a message once it is met
  const auto [known, isNew] = lightSearch_->mentions.try_emplace(file);
  std::string why;
  if (isNew)
    if (const auto source = openFile(file, why)) known->second = mentionsIn(*source);
  const Mentions m = known->second;
  if (!m.lights && !m.archives && !(m.objects && !lightingObjects_.empty())) return false;
  if (m.conditions || (m.objects && !lightingObjects_.empty())) return archive.saysLights(*this, as);
  const auto key = std::make_pair(file, surroundings()->said);
  if (const auto it = lightSearch_->has.find(key); it != lightSearch_->has.end()) return it->second;
  return lightSearch_->has[key] = archive.saysLights(*this, as);
}

bool Interpreter::delay(const Delayed& what, const Request& r) {
  // An object, a solid or a light has what stands in it at once; an inline archive is in memory already.
  if (!read_.delaysProcedurals || (read_.checkOnly && !onlyLooks_) || !world_ || !openObjects_.empty() || solid_ ||
      state_.emitter || inMotion_ || inlineArchives_.contains(what.data[0]) ||
      std::as_const(*state_.attributes).getInt("procedural:immediatesubdivide", 0))
    return false;
  scene::Primitive p;
  p.pos = r.pos;
  scene::OtherPrimitive o{r.name, {}};
  scene::Parameter kind = argument("type", r.pos), data = argument("data", r.pos), bound = argument("bound", r.pos);
  kind.type = data.type = scene::ValueType::String;
  kind.strings = {what.kind};
  data.strings = what.data;
  data.arrayLength = int(what.data.size());
  for (const double x : what.bound) bound.floats.push_back(float(x));
  bound.arrayLength = int(bound.floats.size());
  o.args.set(std::move(kind));
  o.args.set(std::move(data));
  o.args.set(std::move(bound));
  if (!what.parameters.empty()) {
    scene::Parameter given = argument("parameters", r.pos);
    given.type = scene::ValueType::String;
    given.strings = {what.parameters};
    o.args.set(std::move(given));
  }
  p.shape = std::move(o);
  if (!scene::boundOf(p)) return false;
  auto source = std::make_shared<DelayedArchive>(surroundings(), state_, what, r.pos);
  // patterns and inline archives that it may name are a part of what the frame is known by
  Hasher said;
  said.digest(surroundings()->said);
  const auto see = [&](const std::shared_ptr<NodeMap>& nodes) {
    if (!nodes || nodes->empty()) return;
    source->nodes.push_back(nodes);
    said.digest(digestOf(nodes));
  };
  see(outermostNodes_);
  for (const Block& b : blocks_) see(b.nodes);
  scene::Parameter around = argument("around", r.pos);
  around.type = scene::ValueType::String;
  around.strings = {said.result().str()};
  std::get<scene::OtherPrimitive>(p.shape).args.set(std::move(around));
  source->ancestors = ancestors_;
  for (const Source& open : sources_) source->ancestors.push_back(open.identity);
  if (lightSearch_ && !what.isProgram()) {
    scene::Primitive as = p;
    as.toWorld = state_.ctm;
    as.attributes = attributesInUse();
    if (holdsLights(*source, as, what.data[0], r)) return false;
  }
  if (onlyLooks_) return true;
  if (!procedurals_) procedurals_ = std::make_shared<scene::ProceduralSources>();
  (*procedurals_)[nextId_] = std::move(source);  // the id that emit() gives it
  emit(std::move(p));
  return true;
}

}  // namespace kinora::rib
