#include <algorithm>
#include <cfloat>
#include <cmath>
#include <unordered_set>

#include "base/text.h"
#include "rib/interpreter.h"

namespace kinora::rib {

using scene::NodePtr;
using scene::Parameter;

// "plug-in" ["handle"] params. Real files leave the handle out, or give a number.
NodePtr Interpreter::node(Request& r, bool hasHandle, Use use) {
  Cursor c(r);
  auto n = std::make_shared<scene::Node>();
  n->kind = r.name;
  n->pos = r.pos;
  if (!c.string(n->plugin)) {
    badArguments(r, hasHandle ? "the name of a plug-in and a handle" : "the name of a plug-in");
    return nullptr;
  }
  // with a handle the parameter list behind it has even length
  if (hasHandle && c.at < r.count) {
    const bool declared = r.args[c.at].isString() && declarations_.find(r.args[c.at].strings[0]) != nullptr;
    if ((r.count - c.at) % 2 == 1 || !declared) c.string(n->handle);
  }
  if (hasHandle && n->handle.empty()) n->handle = n->plugin;
  n->params = parameters(r, c.at, use);
  return n;
}

const NodePtr* Interpreter::findNode(const std::string& handle) const {
  for (size_t i = blocks_.size(); i-- > 0;)
    if (const auto& nodes = blocks_[i].nodes)
      if (const auto it = nodes->find(handle); it != nodes->end()) return &it->second;
  const auto it = outermostNodes_->find(handle);
  return it == outermostNodes_->end() ? nullptr : &it->second;
}

// Archives that are read later hold the maps as they were.
void Interpreter::remember(const NodePtr& n) {
  const auto add = [&](std::shared_ptr<NodeMap>& nodes) {
    if (!nodes || nodes.use_count() > 1)
      nodes = nodes ? std::make_shared<NodeMap>(*nodes) : std::make_shared<NodeMap>();
    (*nodes)[n->handle] = n;
  };
  for (size_t i = blocks_.size(); i-- > 0;) {
    if (!blocks_[i].state) continue;  // transforms, solids and resources are no scope for nodes
    return add(blocks_[i].nodes);
  }
  add(outermostNodes_);
}

// Depth first over the references, with a stack of our own: each node lands behind all it reads. A reference to
// nothing and one that closes a circle are taken out of the copy of the node that this network holds, so that its
// default is used.
bool Interpreter::gather(NodePtr& terminal, std::vector<NodePtr>& upstream, Missing missing) {
  struct Visit {
    NodePtr node;
    std::vector<std::pair<std::string, std::string>> inputs;  // parameter, handle
    size_t next = 0;
    std::vector<std::string> broken;
  };
  const auto visit = [](const NodePtr& n) {
    Visit v;
    v.node = n;
    for (const Parameter& p : n->params)
      if (p.isReference || p.type >= scene::ValueType::Bxdf)
        for (const std::string& s : p.strings)
          if (!s.empty()) v.inputs.emplace_back(p.name, s.substr(0, s.find(':')));
    return v;
  };
  std::unordered_set<std::string> done, active;
  std::vector<Visit> stack{visit(terminal)};
  while (!stack.empty()) {
    Visit& top = stack.back();
    if (top.next < top.inputs.size()) {
      const auto [parameter, handle] = top.inputs[top.next++];
      if (done.contains(handle)) continue;
      const NodePtr* found = active.contains(handle) ? nullptr : findNode(handle);
      if (found && *found != terminal) {
        active.insert(handle);
        stack.push_back(visit(*found));
        continue;
      }
      const bool circle = active.contains(handle) || found;
      if (!circle && missing == Missing::Stop) return false;
      if (circle || missing == Missing::Report)
        report(Severity::Error, circle ? "RIB-CYCLE" : "RIB-REFERENCE", top.node->pos,
               "\"" + parameter + "\" of " + top.node->kind + " '" + top.node->handle + "' reads '" +
                   handle.substr(0, 60) +
                   (circle ? "', which reads it in turn" : "', which is declared nowhere above"),
               "the parameter's default is used");
      top.broken.push_back(parameter);
      continue;
    }
    NodePtr n = top.node;
    if (!top.broken.empty()) {
      auto repaired = std::make_shared<scene::Node>(*n);
      for (const std::string& name : top.broken) repaired->params.erase(name);
      n = repaired;
    }
    if (stack.size() == 1) {
      terminal = n;
    } else {
      active.erase(n->handle);
      done.insert(n->handle);
      upstream.push_back(n);
    }
    stack.pop_back();
  }
  return true;
}

void Interpreter::pattern(Request& r) {
  if (auto n = node(r, true)) remember(n);
}

// The network as it stands now, so that a pattern declared again later leaves it alone. Where a reference leads
// nowhere yet, `late` keeps the terminal: real files declare patterns behind what reads them.
scene::NetworkPtr Interpreter::bind(const NodePtr& terminal, NodePtr& late) {
  auto network = std::make_shared<scene::Network>();
  network->terminal = terminal;
  late = nullptr;
  if (gather(network->terminal, network->patterns, Missing::Stop)) return network;
  late = terminal;
  network->patterns.clear();
  network->terminal = terminal;
  return network;
}

// Maya's exporter binds a material once, in a scope that holds no object, and elsewhere names it by __materialid
// alone.
void Interpreter::bxdf(Request& r) {
  auto n = node(r, true);
  if (!n) return;
  const Parameter* id = n->params.find("__materialid");
  const std::string key = id && !id->strings.empty() ? n->plugin + '\1' + n->handle + '\1' + id->strings[0] : "";
  if (const auto known = materials_.find(key); known != materials_.end() && n->params.size() == 1) {
    edit().bxdf = known->second;
    state_.lateBxdf = nullptr;
    return;
  }
  auto network = bind(n, state_.lateBxdf);  // before it is remembered: a pattern it reads may have the same handle
  remember(n);                              // layered materials refer to other bxdfs
  if (!key.empty() && !state_.lateBxdf) {
    materials_[key] = network;
    surroundings_ = nullptr;
  }
  edit().bxdf = std::move(network);
}

void Interpreter::displace(Request& r) {
  auto n = node(r, true);
  if (!n) return;
  remember(n);
  edit().displacement = bind(n, state_.lateDisplacement);
}

std::shared_ptr<const scene::Attributes> Interpreter::attributesInUse() {
  const auto resolve = [&](NodePtr& late, scene::NetworkPtr scene::Attributes::*member) {
    if (!late) return;
    auto network = std::make_shared<scene::Network>();
    network->terminal = late;
    if (!gather(network->terminal, network->patterns, Missing::Stop)) {
      network->patterns.clear();
      network->terminal = late;
      // a terminal used by many objects is worth one message
      gather(network->terminal, network->patterns,
             lateReported_.insert(late).second ? Missing::Report : Missing::Drop);
    }
    edit().*member = std::move(network);
    late = nullptr;
  };
  resolve(state_.lateBxdf, &scene::Attributes::bxdf);
  resolve(state_.lateDisplacement, &scene::Attributes::displacement);
  return state_.attributes;
}

void Interpreter::lightFilter(Request& r) {
  auto n = node(r, true);
  if (!n) return;
  remember(n);
  std::erase_if(state_.lightFilters, [&](const LightFilter& f) { return f.node->handle == n->handle; });
  state_.lightFilters.push_back({n, state_.ctm});
}

// LightSource and its like stand apart in the world, where objects list those that shine on them. In an object they
// are lights as all others: they shine from each of its places, on everything.
void Interpreter::addLight(scene::Light l) {
  l.id = nextId_++;
  if (!openObjects_.empty()) {
    if (l.node->kind == "LightSource") lightSourceOf_.erase(l.node->handle);  // Illuminate knows it by its name
    prototypes_[openObjects_.back()].lights.push_back(std::move(l));
    lightingObjects_.insert(openObjects_.back());
    return;
  }
  if (l.node->kind == "LightSource") {
    lightSourceOf_[l.node->handle] = l.id;
    switchLightSource(l.id, true);
  }
  if (!inWorldOrObject())
    frame_.cameraLights.push_back(std::move(l));
  else
    (l.node->kind == "Light" ? world_->lights : world_->classicLights).push_back(std::move(l));
}

void Interpreter::light(Request& r) {
  auto n = node(r, true);
  if (!n) return;
  saysLights_ = true;
  remember(n);
  scene::Light l;
  l.node = n;
  l.toWorld = state_.ctm;
  l.attributes = attributesInUse();
  gather(l.node, l.patterns, Missing::Report);
  // Filters: those in force here, then those the light names and that came from an outer scope.
  for (const LightFilter& f : state_.lightFilters) {
    l.filters.push_back(f.node);
    l.filterToWorld.push_back(f.toWorld);
    std::erase_if(l.patterns, [&](const NodePtr& p) { return p->handle == f.node->handle; });
  }
  for (const NodePtr& p : l.patterns)
    if (p->kind == "LightFilter") {
      l.filters.push_back(p);
      l.filterToWorld.push_back(state_.ctm);
    }
  std::erase_if(l.patterns, [](const NodePtr& p) { return p->kind == "LightFilter"; });
  const std::string plugin = lowerCase(n->plugin);
  if (plugin == "pxrmeshlight") {
    state_.emitter =
        std::make_shared<const scene::Light>(std::move(l));  // becomes a light with each geometry of this block
    return;
  }
  state_.emitter = nullptr;
  addLight(std::move(l));
}

void Interpreter::classicShader(Request& r) {
  auto n = node(r, false, Use::Classic);
  if (!n) return;
  const bool fades = n->kind == "Atmosphere" && (n->plugin == "fog" || n->plugin == "depthcue");
  if (n->kind != "Surface" && !fades) reportKept(r);
  auto& shaders = edit().classicShaders;
  std::erase_if(shaders, [&](const NodePtr& s) { return s->kind == n->kind; });
  shaders.push_back(std::move(n));
}

void Interpreter::lightSource(Request& r) {
  auto n = node(r, true, Use::Classic);
  if (!n) return;
  saysLights_ = true;
  remember(n);
  scene::Light l;
  l.node = std::move(n);
  l.toWorld = state_.ctm;
  l.attributes = state_.attributes;
  addLight(std::move(l));
}

void Interpreter::areaLightSource(Request& r) {
  auto n = node(r, true, Use::Classic);
  if (!n) return;
  saysLights_ = saysLights_ || !n->plugin.empty();
  remember(n);
  auto l = std::make_shared<scene::Light>();
  l->node = std::move(n);
  l->toWorld = state_.ctm;
  l->attributes = state_.attributes;
  state_.emitter = l->node->plugin.empty() ? nullptr : std::shared_ptr<const scene::Light>(std::move(l));
}

// A LightSource joins the list of its attribute block, and with the block's end the list before comes back
// (RISpec 4.1.6).
void Interpreter::switchLightSource(uint32_t id, bool on) {
  std::vector<uint32_t> list;
  if (const auto& held = std::as_const(*state_.attributes).lightSources) list = *held;
  const auto at = std::lower_bound(list.begin(), list.end(), id);
  const bool isOn = at != list.end() && *at == id;
  if (isOn == on) return;
  if (on)
    list.insert(at, id);
  else
    list.erase(at);
  edit().lightSources = list.empty() ? nullptr : std::make_shared<const std::vector<uint32_t>>(std::move(list));
}

// Lights of RIS shine on everything whatever block declares them; those that are switched off here are kept as the
// attribute "illuminate:off", by handle.
void Interpreter::illuminate(Request& r) {
  Cursor c(r);
  std::string handle;
  double on = 1;
  if (!c.string(handle)) return badArguments(r, "a handle and 0 or 1");
  if (c.nextIsString()) {
    std::string word;
    c.string(word);
    on = word == "off" || word == "0" ? 0 : 1;
  } else if (!c.number(on)) {
    return badArguments(r, "a handle and 0 or 1");
  }
  if (const auto source = lightSourceOf_.find(handle); source != lightSourceOf_.end())
    return switchLightSource(source->second, on != 0);
  const Parameter* held = std::as_const(*state_.attributes).named.find("illuminate:off");
  const bool isOff = held && std::find(held->strings.begin(), held->strings.end(), handle) != held->strings.end();
  if (isOff == (on == 0)) return;
  Parameter p;
  if (held) p = *held;
  p.name = "illuminate:off";
  p.type = scene::ValueType::String;
  p.isArray = true;
  if (on == 0)
    p.strings.push_back(handle);
  else
    std::erase(p.strings.edit(), handle);
  p.arrayLength = int(p.strings.size());
  p.pos = r.pos;
  if (p.strings.empty())
    edit().named.erase("illuminate:off");
  else
    edit().named.set(std::move(p));
}

void Interpreter::color(Request& r) {
  Cursor c(r);
  double v[3];
  if (numbers(c, 3, v, "3 numbers")) edit().color = {float(v[0]), float(v[1]), float(v[2])};
}

void Interpreter::opacity(Request& r) {
  Cursor c(r);
  double v[3];
  if (r.count == 1 && r.args[0].size() == 1) {  // one number for all three
    if (numbers(c, 1, v, "3 numbers")) edit().opacity = {float(v[0]), float(v[0]), float(v[0])};
    return;
  }
  if (numbers(c, 3, v, "3 numbers")) edit().opacity = {float(v[0]), float(v[1]), float(v[2])};
}

void Interpreter::textureCoordinates(Request& r) {
  Cursor c(r);
  double v[8];
  if (numbers(c, 8, v, "8 numbers"))
    std::copy_n(v, 8, edit(scene::Attributes::kTextureCoordinates).textureCoordinates.begin());
}

void Interpreter::shadingRate(Request& r) {
  Cursor c(r);
  double v;
  if (!numbers(c, 1, &v, "a rate")) return;
  if (!(v > 0)) return badArguments(r, "a rate above 0");
  edit(scene::Attributes::kShadingRate).shadingRate = float(v);
}

void Interpreter::shadingInterpolation(Request& r) {
  Cursor c(r);
  std::string v;
  if (!c.string(v) || (v != "smooth" && v != "constant")) return badArguments(r, "\"smooth\" or \"constant\"");
  edit(scene::Attributes::kShadingInterpolation).smoothShading = v == "smooth";
}

void Interpreter::matte(Request& r) {
  Cursor c(r);
  double v;
  if (numbers(c, 1, &v, "0 or 1")) edit(scene::Attributes::kMatte).matte = v != 0;
}

void Interpreter::sides(Request& r) {
  Cursor c(r);
  double v;
  if (!numbers(c, 1, &v, "1 or 2")) return;
  if (v != 1 && v != 2) return badArguments(r, "1 or 2");
  edit(scene::Attributes::kSides).sides = int(v);
}

void Interpreter::orientation(Request& r) {
  Cursor c(r);
  std::string v;
  c.string(v);
  using O = scene::Attributes::Orientation;
  const auto set = [&](O o) {
    setOrientation(o);
    edit().reverseOrientation = false;  // it turned the orientation that was
  };
  if (v == "outside")
    set(O::Outside);
  else if (v == "inside")
    set(O::Inside);
  else if (v == "lh")
    set(O::LeftHanded);
  else if (v == "rh")
    set(O::RightHanded);
  else
    badArguments(r, "\"outside\", \"inside\", \"lh\" or \"rh\"");
}

// The orientation flips whenever the coordinate system does (RISpec 4.2.14), so that mirrors behind the request
// change nothing, and those before it tell a named handedness from that of the space it is kept for.
void Interpreter::setOrientation(scene::Attributes::Orientation o) {
  using O = scene::Attributes::Orientation;
  const bool mirrored = std::as_const(state_.ctm).matrices[0].determinant() < 0;
  if (o == O::LeftHanded || o == O::RightHanded) {
    const bool left = (o == O::LeftHanded) != mirrored;
    if (inWorldOrObject())
      o = left ? O::LeftHanded : O::RightHanded;
    else
      o = left ? O::Outside : O::Inside;  // camera space itself, which is left-handed
  }
  edit(scene::Attributes::kOrientation).orientation = o;
}

void Interpreter::reverseOrientation(Request&) {
  scene::Attributes& a = edit();
  a.reverseOrientation = !a.reverseOrientation;
}

namespace {

struct NamedBasis {
  const char* name;
  int step;
  std::array<float, 16> matrix;
};
// Section 7.3 of the RIB reference: rows for [t^3 t^2 t 1].
constexpr float kSixth = 1.f / 6;
const NamedBasis kBases[] = {
    {"bezier", 3, {-1, 3, -3, 1, 3, -6, 3, 0, -3, 3, 0, 0, 1, 0, 0, 0}},
    {"b-spline", 1, {-kSixth, .5f, -.5f, kSixth, .5f, -1, .5f, 0, -.5f, 0, .5f, 0, kSixth, 4 * kSixth, kSixth, 0}},
    {"catmull-rom", 1, {-.5f, 1.5f, -1.5f, .5f, 1, -2.5f, 2, -.5f, -.5f, 0, .5f, 0, 0, 1, 0, 0}},
    {"hermite", 2, {2, 1, -2, 1, -3, -2, 3, -1, 0, 1, 0, 0, 1, 0, 0, 0}},
    {"power", 4, {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}},
};

}  // namespace

void Interpreter::basis(Request& r) {
  Cursor c(r);
  std::array<float, 16> matrices[2];
  int steps[2];
  for (int i = 0; i < 2; ++i) {
    int usual = 3;
    if (c.nextIsString()) {
      std::string name;
      const NamedBasis* found = nullptr;
      if (c.string(name))
        for (const NamedBasis& b : kBases)
          if (name == b.name || (name == "bspline" && b.step == 1 && std::string_view(b.name) == "b-spline"))
            found = &b;
      if (!found) return badArguments(r, "a basis: bezier, b-spline, catmull-rom, hermite, power or 16 numbers");
      matrices[i] = found->matrix;
      usual = found->step;
    } else {
      double v[16];
      if (!numbers(c, 16, v, "two bases, each with its step")) return;
      std::copy_n(v, 16, matrices[i].begin());
    }
    double step = usual;
    if (c.at < r.count && !c.nextIsString() && !numbers(c, 1, &step, "two bases, each with its step")) return;
    if (!(step >= 1 && step <= 16)) return badArguments(r, "steps from 1 to 16");
    steps[i] = int(step);
  }
  scene::Attributes& a = edit();
  a.uBasis = matrices[0];
  a.vBasis = matrices[1];
  a.uStep = steps[0];
  a.vStep = steps[1];
}

void Interpreter::trimCurve(Request& r) {
  static const char* const kNames[] = {"ncurves", "order", "knot", "min", "max", "n", "u", "v", "w"};
  Cursor c(r);
  auto list = std::make_shared<scene::ParameterList>();
  std::vector<int> ncurves, order, n;
  size_t lengths[9] = {};
  for (int i = 0; i < 9; ++i) {
    const bool isInt = i == 0 || i == 1 || i == 5;
    Parameter p;
    p.name = kNames[i];
    p.isArray = true;
    p.pos = r.pos;
    p.type = isInt ? scene::ValueType::Int : scene::ValueType::Float;
    if (isInt ? !c.integers(p.ints.edit()) : !c.floats(p.floats)) return badArguments(r, "nine arrays");
    for (float f : p.floats)
      if (!std::isfinite(f)) return badArguments(r, "finite numbers");
    lengths[i] = p.size();
    p.arrayLength = int(std::min<size_t>(lengths[i], INT32_MAX));
    if (i == 0) ncurves = p.ints;
    if (i == 1) order = p.ints;
    if (i == 5) n = p.ints;
    list->set(std::move(p));
  }
  int64_t curves = 0, points = 0, knots = 0;
  bool sane = true;
  for (int k : ncurves) sane &= k >= 1, curves += k;
  sane &= size_t(curves) == order.size() && size_t(curves) == n.size();
  for (size_t k = 0; sane && k < n.size(); ++k) {
    sane &= order[k] >= 2 && order[k] <= 64 && n[k] >= order[k];
    points += n[k];
    knots += int64_t(n[k]) + order[k];
  }
  const auto has = [&](int i, int64_t wanted) { return lengths[i] == size_t(wanted); };
  if (!sane || !has(2, knots) || !has(3, curves) || !has(4, curves) || !has(6, points) || !has(7, points) ||
      !has(8, points))
    return badArguments(r, "arrays that fit together (loops, orders, knots, ranges, counts, u, v, w)");
  state_.trim = ncurves.empty() ? nullptr : list;
}

}  // namespace kinora::rib
