#include <cmath>
#include <map>
#include <utility>

#include "rib/condition.h"
#include "rib/interpreter.h"
#include "scene/uniform_keys.h"

namespace kinora::rib {

namespace {

const char* const kBlockNames[] = {"Attribute", "Transform", "Frame", "World", "Solid", "Object", "Resource"};

}  // namespace

void Interpreter::open(BlockKind kind, const Request& r) {
  if (blocks_.size() >= size_t(read_.maxBlockDepth)) {
    if (tooDeep_++ == 0)
      report(Severity::Error, "RIB-DEPTH", r.pos,
             r.name + " is nested more than " + std::to_string(read_.maxBlockDepth) + " blocks deep",
             "this block and those inside it are not opened");
    return;
  }
  Block b;
  b.kind = kind;
  b.pos = r.pos;
  b.ctm = state_.ctm;
  b.solid = solid_;
  // all but TransformBegin and MotionBegin save the attributes, and with them the transform (RISpec 4)
  if (kind != BlockKind::Transform && kind != BlockKind::Resource) b.state = std::make_unique<State>(state_);
  if (kind == BlockKind::Frame) b.frame = std::make_unique<FrameState>(frame_);
  blocks_.push_back(std::move(b));
}

void Interpreter::leave() {
  Block b = std::move(blocks_.back());
  blocks_.pop_back();
  solid_ = b.solid;
  switch (b.kind) {
    case BlockKind::World:
      finishWorld();
      break;
    case BlockKind::Object:
      if (!openObjects_.empty()) openObjects_.pop_back();
      break;
    case BlockKind::Frame:
      frame_ = std::move(*b.frame);
      useDirmap(nullptr);
      break;
    default:
      break;
  }
  if (b.state)
    state_ = std::move(*b.state);
  else if (b.kind == BlockKind::Transform)
    state_.ctm = b.ctm;
}

// A block end closes its own block and, with a message, those that were left open inside; attribute and transform
// ends do not reach out of the world, frame or object they stand in.
void Interpreter::close(BlockKind kind, const Request& r) {
  if (tooDeep_ > 0) {
    --tooDeep_;
    return;
  }
  size_t at = blocks_.size();
  while (at > 0 && blocks_[at - 1].kind != kind) {
    const BlockKind between = blocks_[at - 1].kind;
    const bool wall = between == BlockKind::World || between == BlockKind::Frame || between == BlockKind::Object;
    if (wall && kind != BlockKind::Frame && kind != BlockKind::World)
      at = 0;
    else
      --at;
  }
  if (at == 0) {
    report(Severity::Error, "RIB-NESTING", r.pos, r.name + " closes nothing", "it is ignored");
    return;
  }
  if (at < blocks_.size()) {
    const SourcePos& begin = blocks_.back().pos;
    const bool isElsewhere = begin.file && (!r.pos.file || *begin.file != *r.pos.file);
    report(Severity::Error, "RIB-NESTING", r.pos,
           std::string(kBlockNames[int(blocks_.back().kind)]) + "Begin of " +
               (isElsewhere ? begin.str() : "line " + std::to_string(begin.line)) + " is still open at " + r.name,
           "it is closed here");
  }
  while (blocks_.size() >= at) leave();
}

void Interpreter::versionRequest(Request& r) {
  Cursor c(r);
  double v;
  if (!c.number(v)) badArguments(r, "a number");
}

void Interpreter::declareRequest(Request& r) {
  Cursor c(r);
  std::string name, text;
  if (!c.string(name) || !c.string(text)) return badArguments(r, "a name and a declaration");
  if (name.empty() || Declarations::parse(name, true))
    return report(Severity::Error, "RIB-DECLARATION", r.pos,
                  "Declare is given \"" + name.substr(0, 60) + "\" as a name", "the request is ignored",
                  "the type stands in its second argument alone");
  if (!declarations_.declare(name, text))
    report(Severity::Error, "RIB-DECLARATION", r.pos, "\"" + text.substr(0, 60) + "\" is not a declaration",
           "\"" + name.substr(0, 60) + "\" stays undeclared",
           "it reads \"[class] type[n]\", as in \"uniform float[2]\"");
}

void Interpreter::frameBegin(Request& r) {
  Cursor c(r);
  double number = 0;
  if (!c.number(number) || !std::isfinite(number)) badArguments(r, "a frame number"), number = 0;
  if (world_ && sources_.size() > worldSources_) {
    report(Severity::Error, "RIB-NESTING", r.pos, "FrameBegin in an archive that is read inside a world",
           "what stands in it is part of the world around it");
    innerFrames_.push_back(sources_.size());
    return open(BlockKind::Attribute, r);
  }
  for (const Block& b : blocks_)
    if (b.kind == BlockKind::Frame || b.kind == BlockKind::World) {
      report(Severity::Error, "RIB-NESTING", r.pos, "FrameBegin inside a frame or world",
             "the one before is closed first");
      close(b.kind == BlockKind::Frame ? BlockKind::Frame : BlockKind::World, r);
      break;
    }
  open(BlockKind::Frame, r);
  frame_.options.frame = int(std::max(-2e9, std::min(2e9, number)));
  frame_.options.hasFrame = true;
}
void Interpreter::frameEnd(Request& r) { closeInner(innerFrames_, BlockKind::Frame, r); }

// The end of a frame or world that is part of the world around it ends the attribute block that stands for it.
void Interpreter::closeInner(std::vector<size_t>& inner, BlockKind kind, const Request& r) {
  // an archive that was cut short has ended its own with itself
  while (!inner.empty() && inner.back() > sources_.size()) inner.pop_back();
  if (inner.empty()) return close(kind, r);
  inner.pop_back();
  close(BlockKind::Attribute, r);
}

void Interpreter::worldBegin(Request& r) {
  if (world_ && sources_.size() > worldSources_) {
    report(Severity::Error, "RIB-NESTING", r.pos, "WorldBegin in an archive that is read inside a world",
           "what stands in it is part of the world around it");
    innerWorlds_.push_back(sources_.size());
    return open(BlockKind::Attribute, r);
  }
  if (world_) {
    report(Severity::Error, "RIB-NESTING", r.pos, "WorldBegin inside a world", "the world before is ended first");
    close(BlockKind::World, r);
  }
  const size_t depth = blocks_.size();
  open(BlockKind::World, r);
  if (blocks_.size() == depth) return;
  world_ = frame_.options;
  world_->pos = r.pos;
  procedurals_ = nullptr;
  lookedInto_ = 0;
  worldPrototypes_ = nullptr;
  onlyScoped_.clear();
  worldSources_ = sources_.size();
  innerWorlds_.clear();
  innerFrames_.clear();
  // The primary camera is the one named "world"; else the first Camera request that placed it; else what stands here.
  scene::Camera primary = frame_.camera;
  primary.name = "world";
  primary.worldToCamera = state_.ctm;
  primary.pos = r.pos;
  auto& cameras = world_->cameras;
  size_t chosen = cameras.size();
  for (size_t i = 0; i < cameras.size() && chosen == cameras.size(); ++i)
    if (cameras[i].name == "world") chosen = i;
  const auto sameMatrices = [&](const scene::Transform& t) { return t.matrices == state_.ctm.matrices; };
  if (chosen == cameras.size() && !cameras.empty() &&
      (sameMatrices(scene::Transform()) || sameMatrices(cameras[0].worldToCamera)))
    chosen = 0;
  if (chosen == cameras.size())
    cameras.insert(cameras.begin(), std::move(primary));
  else
    std::rotate(cameras.begin(), cameras.begin() + long(chosen), cameras.begin() + long(chosen) + 1);
  const scene::Transform cameraToWorld = cameras[0].worldToCamera.inverse();
  auto& spaces = world_->coordinateSystems;
  spaces["world"] = scene::Transform();
  spaces["camera"] = cameraToWorld;
  for (const auto& [name, toCamera] : frame_.cameraSpaces) spaces[name] = concat(toCamera, cameraToWorld);
  // What was said before stands in camera space. Patterns find systems of scopes by name alone, as in the world.
  const auto spacesToWorld = [&](const scene::Attributes& a) {
    auto scoped = std::make_shared<std::map<std::string, scene::Transform>>(*a.coordinateSystems);
    for (auto& [name, space] : *scoped) {
      space = concat(space, cameraToWorld);
      if (spaces.try_emplace(name, space).second) onlyScoped_.insert(name);
    }
    return scoped;
  };
  const auto lightToWorld = [&](scene::Light& l) {
    l.toWorld = concat(l.toWorld, cameraToWorld);
    for (scene::Transform& filter : l.filterToWorld) filter = concat(filter, cameraToWorld);
    if (!l.attributes || !l.attributes->coordinateSystems) return;
    auto own = std::make_shared<scene::Attributes>(*l.attributes);
    own->coordinateSystems = spacesToWorld(*l.attributes);
    l.attributes = std::move(own);
  };
  if (state_.attributes->coordinateSystems) edit().coordinateSystems = spacesToWorld(*state_.attributes);
  for (LightFilter& f : state_.lightFilters) f.toWorld = concat(f.toWorld, cameraToWorld);
  if (state_.emitter) {
    auto own = std::make_shared<scene::Light>(*state_.emitter);
    lightToWorld(*own);
    state_.emitter = std::move(own);
  }
  for (scene::Light l : frame_.cameraLights) {
    lightToWorld(l);
    (l.node->kind == "Light" ? world_->lights : world_->classicLights).push_back(std::move(l));
  }
  state_.ctm = scene::Transform();
}

void Interpreter::worldEnd(Request& r) { closeInner(innerWorlds_, BlockKind::World, r); }

void Interpreter::finishWorld() {
  if (!world_) return;
  world_->prototypes = prototypes_;
  if (worldPrototypes_) *worldPrototypes_ = prototypes_;
  doneProcedurals_ = std::move(procedurals_);
  worldPrototypes_ = nullptr;
  surroundings_ = nullptr;
  world_->nextId = nextId_;
  scene::Scene done = std::move(*world_);
  held_.set(0);  // whoever takes the world charges it
  world_.reset();
  useDirmap(nullptr);
  ++worlds_;
  if (onWorld_) onWorld_(std::move(done));
}

void Interpreter::attributeBegin(Request& r) { open(BlockKind::Attribute, r); }
void Interpreter::attributeEnd(Request& r) { close(BlockKind::Attribute, r); }
void Interpreter::transformBegin(Request& r) { open(BlockKind::Transform, r); }
void Interpreter::transformEnd(Request& r) { close(BlockKind::Transform, r); }
void Interpreter::resourceBegin(Request& r) { open(BlockKind::Resource, r); }
void Interpreter::resourceEnd(Request& r) { close(BlockKind::Resource, r); }

void Interpreter::solidBegin(Request& r) {
  using Operation = scene::Solid::Operation;
  static const std::map<std::string, Operation, std::less<>> kOperations{{"primitive", Operation::Primitive},
                                                                         {"union", Operation::Union},
                                                                         {"intersection", Operation::Intersection},
                                                                         {"difference", Operation::Difference}};
  Cursor c(r);
  std::string name;
  const auto it = c.string(name) ? kOperations.find(name) : kOperations.end();
  const size_t depth = blocks_.size();
  open(BlockKind::Solid, r);
  if (blocks_.size() == depth || !inWorldOrObject()) return;
  const uint32_t outer = std::exchange(solid_, 0);
  if (it == kOperations.end()) {
    report(Severity::Error, "RIB-SOLID", r.pos, "'" + name.substr(0, 60) + "' is no operation of solids",
           "what stands in this block is drawn as it is",
           "there are \"primitive\", \"union\", \"intersection\" and \"difference\"");
    return;
  }
  std::vector<scene::Solid>& solids = solidsHere();
  if (outer && solids[outer - 1].operation == Operation::Primitive)
    report(Severity::Warning, "RIB-SOLID", r.pos, "a solid stands in a primitive solid", "they are united",
           "the operands of a union stand in a block of \"union\"");
  solids.push_back({it->second, outer, r.pos});
  solid_ = uint32_t(solids.size());
}

uint32_t Interpreter::solidHere(const SourcePos& pos) {
  if (!solid_) return 0;
  std::vector<scene::Solid>& solids = solidsHere();
  if (solids[solid_ - 1].operation == scene::Solid::Operation::Primitive) return solid_;
  solids.push_back({scene::Solid::Operation::Primitive, solid_, pos});
  return uint32_t(solids.size());
}
void Interpreter::solidEnd(Request& r) { close(BlockKind::Solid, r); }

void Interpreter::objectBegin(Request& r) {
  Cursor c(r);
  std::string handle;
  if (!c.string(handle)) badArguments(r, "a handle: the object cannot be used");
  const size_t depth = blocks_.size();
  open(BlockKind::Object, r);
  if (blocks_.size() == depth) return;
  // What stands outside is the instance's business (RISpec 5.9), but for what the points need to be understood: bases.
  auto clean = std::make_shared<scene::Attributes>();
  const scene::Attributes& outer = *state_.attributes;
  clean->uBasis = outer.uBasis;
  clean->vBasis = outer.vBasis;
  clean->uStep = outer.uStep;
  clean->vStep = outer.vStep;
  state_ = State{clean, scene::Transform(), {}, nullptr, state_.trim, nullptr, nullptr};
  solid_ = 0;
  const auto index = uint32_t(prototypes_.size());
  scene::Prototype p;
  p.name = handle;
  p.pos = r.pos;
  prototypes_.push_back(std::move(p));
  openObjects_.push_back(index);
  if (!handle.empty()) prototypeByHandle_[handle] = index;
}
void Interpreter::objectEnd(Request& r) { close(BlockKind::Object, r); }

// An object like the one at `prototype` whose shapes, in the objects within it too, are lights like `emitter` instead.
static uint32_t lampOf(uint32_t prototype, const scene::Light& emitter, std::vector<scene::Prototype>& prototypes,
                       uint32_t& nextId, std::map<uint32_t, uint32_t>& made) {
  if (const auto it = made.find(prototype); it != made.end()) return it->second;
  const scene::Prototype from = prototypes[prototype];
  scene::Prototype lamp;
  lamp.name = from.name;
  lamp.pos = from.pos;
  lamp.lights = from.lights;
  for (const scene::PrimitivePtr& shape : from.primitives) {
    scene::Light l = emitter;
    l.id = nextId++;
    l.toWorld = shape->toWorld;
    l.attributes = shape->attributes;
    l.geometry = *shape;
    lamp.lights.push_back(std::move(l));
  }
  for (size_t k = 0; k < from.instances.size(); ++k) {
    scene::Instance i = from.instances[k];
    i.id = nextId++;
    i.solid = 0;
    i.prototype = lampOf(i.prototype, emitter, prototypes, nextId, made);
    lamp.instances.push_back(std::move(i));
  }
  prototypes.push_back(std::move(lamp));
  return made[prototype] = uint32_t(prototypes.size()) - 1;
}

void Interpreter::objectInstance(Request& r) {
  Cursor c(r);
  std::string handle;
  if (!c.string(handle)) return badArguments(r, "a handle");
  auto it = prototypeByHandle_.find(handle);
  if (it == prototypeByHandle_.end() && findInDelayed(handle)) it = prototypeByHandle_.find(handle);
  if (it == prototypeByHandle_.end()) {
    report(Severity::Error, "RIB-HANDLE", r.pos, "no object is called '" + handle.substr(0, 60) + "'",
           "the instance is ignored", "ObjectBegin must stand before ObjectInstance");
    return;
  }
  for (const uint32_t open : openObjects_)
    if (open == it->second) {
      report(Severity::Error, "RIB-RECURSION", r.pos,
             "the object '" + handle.substr(0, 60) + "' holds an instance of itself", "the instance is ignored");
      return;
    }
  if (!inWorldOrObject()) {
    ++outsideWorld_;
    return;
  }
  if (r.count > 1)
    report(Severity::Warning, "RIB-INSTANCE-VALUES", r.pos,
           "ObjectInstance has parameters of its own, and instances take none", "they are ignored",
           "Attribute \"user\" before it and the pattern PxrAttribute tell instances apart");
  if (lightingObjects_.contains(it->second)) {
    saysLights_ = true;
    if (!openObjects_.empty()) lightingObjects_.insert(openObjects_.back());
  }
  scene::Instance i;
  i.prototype = it->second;
  i.toWorld = state_.ctm;
  i.attributes = attributesInUse();
  if (const scene::Parameter* set = i.attributes->named.find("shade:faceset")) {
    if (!set->ints.empty()) i.prototype = withFaces(i.prototype, set->ints, r);
    i.attributes = withoutFaceSet(i.attributes);
  }
  if (state_.emitter) {  // its geometry belongs to the light alone
    if (!openObjects_.empty()) lightingObjects_.insert(openObjects_.back());
    if (lampsOf_ != state_.emitter) {
      lampsOf_ = state_.emitter;
      lamps_.clear();
    }
    i.prototype = lampOf(i.prototype, *state_.emitter, prototypes_, nextId_, lamps_);
  } else {
    i.solid = solidHere(r.pos);
  }
  i.id = nextId_++;
  i.pos = r.pos;
  (openObjects_.empty() ? world_->instances : prototypes_[openObjects_.back()].instances).push_back(std::move(i));
}

// Resource "handle" "attributes" "string operation" "save" | "restore" "string subset" "all" | "shading" |
// "transform" ...
void Interpreter::resource(Request& r) {
  Cursor c(r);
  std::string handle, type;
  if (!c.string(handle) || !c.string(type)) return badArguments(r, "a handle and a type");
  if (type != "attributes") return keep(r);
  const scene::ParameterList p = parameters(r, c.at, Use::Node);
  const std::string operation = p.getString("operation", "restore"), subset = p.getString("subset", "all");
  if (operation == "save") {
    resources_[handle] = state_;
    return;
  }
  const auto it = resources_.find(handle);
  if (it == resources_.end()) {
    report(Severity::Error, "RIB-HANDLE", r.pos, "no resource is called '" + handle.substr(0, 60) + "'",
           "nothing is restored");
    return;
  }
  const State& saved = it->second;
  if (subset == "all") {
    state_ = saved;
  } else if (subset == "transform") {
    state_.ctm = saved.ctm;
  } else if (subset == "shading") {
    scene::Attributes& a = edit();
    a.bxdf = saved.attributes->bxdf;
    a.displacement = saved.attributes->displacement;
    a.classicShaders = saved.attributes->classicShaders;
    a.color = saved.attributes->color;
    a.opacity = saved.attributes->opacity;
    state_.lateBxdf = saved.lateBxdf;
    state_.lateDisplacement = saved.lateDisplacement;
  } else {
    report(Severity::Warning, "RIB-RESOURCE", r.pos,
           "the resource subset '" + subset.substr(0, 40) + "' is not known",
           "all attributes but the transform are restored");
    const scene::Transform ctm = state_.ctm;
    state_ = saved;
    state_.ctm = ctm;
  }
}

void Interpreter::motionBegin(Request& r) {
  if (inMotion_) {
    report(Severity::Error, "RIB-MOTION", r.pos, "MotionBegin inside MotionBegin", "the inner one is ignored");
    return;
  }
  inMotion_ = true;
  motionPos_ = r.pos;
  motionTimes_.clear();
  motionRequests_.clear();
  isMotionCut_ = false;
  const double offset = (world_ ? *world_ : frame_.options).options.getFloat("shutter:offset", 0);
  for (size_t i = 0; i < r.count; ++i) {
    const Argument& a = r.args[i];
    if (a.kind == Argument::Kind::Strings) break;
    for (size_t k = 0; k < a.size(); ++k)
      motionTimes_.push_back(offset + (k < a.exact.size() ? a.exact[k]
                                       : a.isInteger      ? double(a.ints[k])
                                                          : double(a.floats[k])));
  }
  for (size_t k = 0; k < motionTimes_.size(); ++k)
    if (!std::isfinite(motionTimes_[k]) || (k > 0 && !(motionTimes_[k] > motionTimes_[k - 1]))) {
      report(Severity::Error, "RIB-MOTION", r.pos, "the times of MotionBegin do not increase",
             k > 1 ? "only the first " + std::to_string(k) + " are used" : "what is in the block does not move");
      motionTimes_.resize(k);
      isMotionCut_ = true;
      break;
    }
}

void Interpreter::motionEnd(Request& r) {
  if (!inMotion_) {
    report(Severity::Error, "RIB-NESTING", r.pos, "MotionEnd closes nothing", "it is ignored");
    return;
  }
  inMotion_ = false;
  std::vector<Request> keys;
  std::swap(keys, motionRequests_);
  std::vector<double> times = motionTimes_;
  if (keys.empty()) {
    report(Severity::Warning, "RIB-MOTION", motionPos_, "MotionBegin ... MotionEnd holds no request",
           "it is ignored");
    return;
  }
  const Family family = [&] {
    const auto it = table().find(keys[0].name);
    return it == table().end() ? Family::Other : it->second.family;
  }();
  for (size_t k = 1; k < keys.size(); ++k)
    if (keys[k].name != keys[0].name) {
      report(Severity::Error, "RIB-MOTION", keys[k].pos,
             keys[k].name + " stands in a motion block of " + keys[0].name, "it and those after it are ignored");
      keys.resize(k);
      times.resize(std::min(times.size(), k));
      break;
    }
  if (keys.size() != times.size()) {
    const size_t n = std::min(keys.size(), times.size());
    if (!isMotionCut_)  // else the times are what is wrong, and that has been said
      report(Severity::Error, "RIB-MOTION", motionPos_,
             "MotionBegin has " + std::to_string(times.size()) + " times and " + std::to_string(keys.size()) +
                 " requests",
             n > 1 ? "the first " + std::to_string(n) + " are used" : "the first request is used, without motion");
    if (n == 0) times.assign(1, 0.0);
    keys.resize(std::max<size_t>(n, 1));
    times.resize(keys.size());
  }
  const bool canMove = family == Family::Transform || family == Family::Geometry;
  if (canMove && scene::areCloserThanKeys(times, frame_.camera.shutter[0], frame_.camera.shutter[1]))
    report(Severity::Warning, "RIB-MOTION-CLOSE", motionPos_,
           "times of MotionBegin are closer to each other than 1/" + std::to_string(scene::kMostUniformKeys - 1) +
               " of the time that the shutter is open",
           "what happens between them takes as long as that");
  if (keys.size() > 1 && family == Family::Transform) return applyTransforms(keys, times);
  if (keys.size() > 1 && family == Family::Geometry) return applyGeometry(keys, times);
  if (keys.size() > 1)
    report(Severity::Warning, "RIB-MOTION-STATIC", keys[0].pos, keys[0].name + " does not move",
           "its first value is used");
  execute(keys[0]);
}

bool Interpreter::condition(Request& r) {
  Cursor c(r);
  std::string expression, problem;
  if (!c.string(expression)) return badArguments(r, "an expression"), false;
  const bool v = evaluateCondition(
      expression, [this](std::string_view n) { return lookUp(n); }, problem);
  if (!problem.empty())
    report(Severity::Warning, "RIB-CONDITION", r.pos,
           "the condition \"" + expression.substr(0, 80) + "\" cannot be evaluated: " + problem,
           "it counts as false");
  return v;
}

void Interpreter::ifBegin(Request& r) {
  constexpr size_t kMostConditions = 100000;
  if (conditions_.size() >= kMostConditions) {
    if (unopenedIfs_++ == 0)
      report(Severity::Error, "RIB-DEPTH", r.pos, "IfBegin is nested more than 100000 deep",
             "this one and those inside it do not count");
    return;
  }
  Condition c;
  c.pos = r.pos;
  c.active = c.taken = inactive_ == 0 && condition(r);
  inactive_ += !c.active;
  conditions_.push_back(c);
}

// Whether one is open that what is read now began: an archive leaves those around it alone, as its own end with it.
bool Interpreter::hasOwnCondition() const {
  const size_t around = sources_.size() > 1 ? sources_.back().conditions : 0;
  return conditions_.size() > around;
}

// The block whose next part begins with this request, the part before being over. Null: there is none.
Interpreter::Condition* Interpreter::endPart(Request& r, const std::string& name) {
  if (unopenedIfs_ > 0) return nullptr;
  if (!hasOwnCondition()) {
    report(Severity::Error, "RIB-NESTING", r.pos, name + " without IfBegin", "it is ignored");
    return nullptr;
  }
  Condition& c = conditions_.back();
  inactive_ -= !c.active;
  return &c;
}

void Interpreter::elseIf(Request& r) {
  Condition* c = endPart(r, "ElseIf");
  if (!c) return;
  c->active = inactive_ == 0 && !c->taken && !c->sawElse && condition(r);
  c->taken |= c->active;
  inactive_ += !c->active;
}

void Interpreter::elseRequest(Request& r) {
  Condition* c = endPart(r, "Else");
  if (!c) return;
  c->active = inactive_ == 0 && !c->taken && !c->sawElse;
  c->taken = c->sawElse = true;
  inactive_ += !c->active;
}

void Interpreter::ifEnd(Request& r) {
  if (unopenedIfs_ > 0) {
    --unopenedIfs_;
    return;
  }
  if (!hasOwnCondition())
    return report(Severity::Error, "RIB-NESTING", r.pos, "IfEnd without IfBegin", "it is ignored");
  inactive_ -= !conditions_.back().active;
  conditions_.pop_back();
}

// Edit blocks speak to a running interactive render; in a file they would change a picture that is already made.
void Interpreter::editBegin(Request& r) {
  keep(r);
  inEdit_ = true;
  editPos_ = r.pos;
}
void Interpreter::editEnd(Request& r) {
  if (!inEdit_) report(Severity::Warning, "RIB-NESTING", r.pos, "EditEnd closes nothing", "it is ignored");
  inEdit_ = false;
}

}  // namespace kinora::rib
