#include "rib/writer.h"

#include <map>
#include <set>

#include "rib/words.h"

namespace kinora::rib {

using namespace scene;

namespace {

class Writer {
 public:
  explicit Writer(const TextSink& sink) : sink_(sink) {}
  ~Writer() { sink_(text_); }

  void scene(const Scene& s);

 private:
  // ---- words
  template <class T>
  void number(T v) {
    appendNumber(v, text_);
  }
  void string(std::string_view s) { appendString(s, text_); }
  template <class T>
  void array(const T& values) {
    text_ += " [";
    bool first = true;
    for (const auto& v : values) {
      if (!first) text_ += ' ';
      first = false;
      if constexpr (std::is_convertible_v<decltype(v), std::string_view>)
        string(v);
      else
        number(v);
      if (text_.size() > kFlush) flush();
    }
    text_ += ']';
  }
  void flush() {
    sink_(text_);
    text_.clear();
  }
  void begin(std::string_view request) {
    if (text_.size() > kFlush) flush();
    text_ += request;
  }
  void end() { text_ += '\n'; }
  void word(std::string_view s) {
    text_ += ' ';
    string(s);
  }
  template <class... T>
  void request(std::string_view name, const T&... args) {
    begin(name);
    (argument(args), ...);
    end();
  }
  void argument(std::string_view s) { word(s); }
  void argument(const std::string& s) { word(s); }
  void argument(const char* s) { word(s); }
  template <class T>
  requires std::is_arithmetic_v<T>
  void argument(T v) {
    text_ += ' ';
    number(v);
  }
  template <class T, size_t N>
  void argument(const std::array<T, N>& v) {
    array(v);
  }
  template <class T>
  void argument(const std::vector<T>& v) {
    array(v);
  }
  template <class T>
  void argument(const LeanVector<T>& v) {
    array(v);
  }
  void argument(const Keys<double>& v) { array(std::vector<double>(v.begin(), v.end())); }

  // ---- parts
  void parameter(const Parameter& p, std::string_view name) {
    std::string token = nameOf(p.storage);
    token += p.isReference ? " reference " : " ";
    token += nameOf(p.type);
    if (p.isArray) token += "[" + std::to_string(p.arrayLength) + "]";
    word(token + " " + std::string(name));
    if (!p.strings.empty())
      array(p.strings);
    else if (!p.ints.empty())
      array(p.ints);
    else
      array(p.floats);
  }
  void parameters(const ParameterList& list) {
    for (const Parameter& p : list) parameter(p, p.name);
  }
  void grouped(const char* requestName, const ParameterList& list) {
    for (const Parameter& p : list) {
      const size_t colon = p.name.find(':');
      if (p.name == "illuminate:off") {
        for (const std::string& handle : p.strings) request("Illuminate", handle, 0);
        continue;
      }
      begin(requestName);
      word(p.name.substr(0, colon));
      parameter(p, colon == std::string::npos ? p.name : p.name.substr(colon + 1));
      end();
    }
  }
  void matrix(const char* name, const Matrix& m) {
    begin(name);
    text_ += " [";
    for (int i = 0; i < 16; ++i) {
      if (i) text_ += ' ';
      number(m[i / 4][i % 4]);
    }
    text_ += ']';
    end();
  }
  void transform(const Transform& t) {
    if (t.isStatic()) {
      if (t.matrices[0] != Matrix()) matrix("Transform", t.matrices[0]);
      return;
    }
    request("MotionBegin", t.times);
    for (const Matrix& m : t.matrices) matrix("Transform", m);
    request("MotionEnd");
  }
  void node(const Node& n, bool hasHandle) {
    begin(n.kind);
    word(n.plugin);
    if (hasHandle) word(n.handle);
    parameters(n.params);
    end();
  }
  void network(const NetworkPtr& n) {
    if (!n) return;
    for (const NodePtr& p : n->patterns) node(*p, true);
    node(*n->terminal, true);
  }
  void attributes(const AttributesPtr& a);
  void shape(const Primitive& p, const ParameterList& primvars, const ParameterList* moved);
  void primitive(const Primitive& p);
  void light(const Light& l);
  void camera(const Camera& c, bool primary);
  void instance(const Instance& i) {
    if (i.prototype >= names_.size()) return;
    request("AttributeBegin");
    attributes(i.attributes);
    transform(i.toWorld);
    request("ObjectInstance", names_[i.prototype]);
    request("AttributeEnd");
  }
  // Of a scene or a prototype: what is no part of a solid, then the solids with what bounds them.
  template <class Owner>
  void contents(const Owner& owner) {
    for (const Light& l : owner.lights) light(l);
    std::vector<std::vector<const Primitive*>> primitivesOf(owner.solids.size() + 1);
    std::vector<std::vector<size_t>> instancesOf(owner.solids.size() + 1);
    const auto place = [&](uint32_t solid) { return solid <= owner.solids.size() ? solid : 0; };
    for (const PrimitivePtr& p : owner.primitives) primitivesOf[place(p->solid)].push_back(p.get());
    for (size_t i = 0; i < owner.instances.size(); ++i) instancesOf[place(owner.instances.solidOf(i))].push_back(i);
    std::vector<uint32_t> open;
    const auto closeTo = [&](uint32_t solid) {
      for (; !open.empty() && open.back() != solid; open.pop_back()) request("SolidEnd");
    };
    for (uint32_t solid = 0; solid <= owner.solids.size(); ++solid) {
      if (solid) {
        closeTo(owner.solids[solid - 1].parent);
        static constexpr const char* kOperations[] = {"primitive", "union", "intersection", "difference"};
        request("SolidBegin", kOperations[int(owner.solids[solid - 1].operation)]);
        open.push_back(solid);
      }
      for (const Primitive* p : primitivesOf[solid]) primitive(*p);
      for (const size_t i : instancesOf[solid]) instance(owner.instances[i]);
    }
    closeTo(0);
  }
  void prototypes(const std::vector<Prototype>& list);

  static constexpr size_t kFlush = 1 << 16;
  const TextSink& sink_;
  std::string text_;
  std::vector<std::string> names_;                // of prototypes, made unique
  std::map<uint32_t, NodePtr> lamps_;             // primitives that are area lights as well, by id
  std::map<uint32_t, std::string> lightSources_;  // handles by id
};

void Writer::attributes(const AttributesPtr& shared) {
  if (!shared) return;
  const Attributes& a = *shared;
  using A = Attributes;
  const Attributes usual;
  static const char* const kOrientations[] = {"outside", "inside", "lh", "rh"};
  if (a.coordinateSystems)
    for (const auto& [name, space] : *a.coordinateSystems) {
      request("TransformBegin");
      transform(space);
      request("ScopedCoordinateSystem", name);
      request("TransformEnd");
    }
  // "Attribute Ri" sets the classic state too, so that the requests follow it
  grouped("Attribute", a.named);
  if (a.lightSources)
    for (const uint32_t id : *a.lightSources)
      if (const auto known = lightSources_.find(id); known != lightSources_.end())
        request("Illuminate", known->second, 1);
  if (a.color) request("Color", *a.color);
  if (a.opacity) request("Opacity", *a.opacity);
  if (a.says(A::kTextureCoordinates)) request("TextureCoordinates", a.textureCoordinates);
  if (a.says(A::kOrientation)) request("Orientation", kOrientations[int(a.orientation)]);
  // the orientation undoes what "Attribute Ri" said of its reverse
  const bool said = !a.says(A::kOrientation) && a.named.getInt("Ri:ReverseOrientation", 0) != 0;
  if (a.reverseOrientation != said) request("ReverseOrientation");
  if (a.says(A::kSides)) request("Sides", a.sides);
  if (a.says(A::kMatte)) request("Matte", int(a.matte));
  if (a.says(A::kShadingInterpolation)) request("ShadingInterpolation", a.smoothShading ? "smooth" : "constant");
  if (a.says(A::kShadingRate)) request("ShadingRate", a.shadingRate);
  if (a.uBasis != usual.uBasis || a.vBasis != usual.vBasis || a.uStep != usual.uStep || a.vStep != usual.vStep)
    request("Basis", a.uBasis, a.uStep, a.vBasis, a.vStep);
  for (const NodePtr& s : a.classicShaders) node(*s, false);
  network(a.displacement);
  network(a.bxdf);
}

void Writer::shape(const Primitive& p, const ParameterList& primvars, const ParameterList* moved) {
  struct Visitor {
    Writer& w;
    const ParameterList* moved;
    void operator()(const Quadric& q) const {
      static const std::pair<const char*, size_t> kForms[] = {{"Sphere", 4},      {"Cone", 3},       {"Cylinder", 4},
                                                              {"Hyperboloid", 7}, {"Paraboloid", 4}, {"Disk", 3},
                                                              {"Torus", 5}};
      const auto& [name, count] = kForms[int(q.kind)];
      std::vector<float> args(q.args.begin(), q.args.end());
      if (moved)
        if (const auto v = moved->getFloats("__quadric"); v.size() == args.size()) args = v;
      args.resize(count);
      w.begin(name);
      for (const float v : args) w.argument(v);
    }
    void operator()(const PolygonMesh& m) const {
      if (m.vertices.empty()) {
        w.begin(m.loopsPerFace.empty() ? "Polygon" : "GeneralPolygon");
        if (!m.loopsPerFace.empty()) w.argument(m.verticesPerLoop);
        return;
      }
      w.begin(m.loopsPerFace.empty() ? "PointsPolygons" : "PointsGeneralPolygons");
      if (!m.loopsPerFace.empty()) w.argument(m.loopsPerFace);
      w.argument(m.verticesPerLoop);
      w.argument(m.vertices);
    }
    void operator()(const SubdivisionMesh& m) const {
      w.begin("HierarchicalSubdivisionMesh");
      w.argument(m.scheme);
      w.argument(m.verticesPerFace);
      w.argument(m.vertices);
      std::vector<std::string> names, strings;
      std::vector<int> counts, ints;
      std::vector<float> floats;
      for (const auto& t : m.tags) {
        names.push_back(t.name);
        for (const size_t n : {t.ints.size(), t.floats.size(), t.strings.size()}) counts.push_back(int(n));
        ints.insert(ints.end(), t.ints.begin(), t.ints.end());
        floats.insert(floats.end(), t.floats.begin(), t.floats.end());
        strings.insert(strings.end(), t.strings.begin(), t.strings.end());
      }
      w.argument(names);
      w.argument(counts);
      w.argument(ints);
      w.argument(floats);
      w.argument(strings);
    }
    void operator()(const scene::Curves& c) const {
      w.begin("Curves");
      w.argument(c.cubic ? "cubic" : "linear");
      w.argument(c.verticesPerCurve);
      w.argument(c.periodic ? "periodic" : "nonperiodic");
    }
    void operator()(const Points&) const { w.begin("Points"); }
    void operator()(const Patch& p) const {
      w.begin("Patch");
      w.argument(p.bicubic ? "bicubic" : "bilinear");
    }
    void operator()(const PatchMesh& p) const {
      w.begin("PatchMesh");
      w.argument(p.bicubic ? "bicubic" : "bilinear");
      w.argument(p.nu);
      w.argument(p.uPeriodic ? "periodic" : "nonperiodic");
      w.argument(p.nv);
      w.argument(p.vPeriodic ? "periodic" : "nonperiodic");
    }
    void operator()(const NuPatch& p) const {
      w.begin("NuPatch");
      w.argument(p.nu);
      w.argument(p.uOrder);
      w.argument(p.uKnots);
      w.argument(p.uMin);
      w.argument(p.uMax);
      w.argument(p.nv);
      w.argument(p.vOrder);
      w.argument(p.vKnots);
      w.argument(p.vMin);
      w.argument(p.vMax);
    }
    // positional arguments stand in `args` in the order of the request
    void operator()(const OtherPrimitive& o) const {
      w.begin(o.request);
      for (const Parameter& a : o.args) {
        const bool scalar = a.name == "type" || a.name == "nleaf" || (a.name == "data" && o.request == "Procedural2");
        if (!a.strings.empty())
          scalar ? w.argument(a.strings[0]) : w.argument(a.strings);
        else if (!a.ints.empty())
          scalar ? w.argument(a.ints[0]) : w.argument(a.ints);
        else
          w.argument(a.floats);
      }
    }
  };
  std::visit(Visitor{*this, moved}, p.shape);
  for (const Parameter& v : primvars)
    if (v.name != "__quadric") parameter(v, v.name);
  end();
}

void Writer::primitive(const Primitive& p) {
  request("AttributeBegin");
  attributes(p.attributes);
  if (const auto it = lamps_.find(p.id); it != lamps_.end()) node(*it->second, true);
  transform(p.toWorld);
  if (const auto* n = std::get_if<NuPatch>(&p.shape); n && !n->trim.empty()) {
    begin("TrimCurve");
    for (const Parameter& a : n->trim) a.ints.empty() ? array(a.floats) : array(a.ints);
    end();
  }
  if (!p.times.empty()) request("MotionBegin", p.times);
  shape(p, p.primvars, nullptr);
  for (const ParameterList& m : p.motion) shape(p, m, &m);
  if (!p.times.empty()) request("MotionEnd");
  request("AttributeEnd");
}

void Writer::light(const Light& l) {
  request("AttributeBegin");
  attributes(l.attributes);
  for (size_t i = 0; i < l.filters.size(); ++i) {
    request("TransformBegin");
    if (i < l.filterToWorld.size()) transform(l.filterToWorld[i]);
    node(*l.filters[i], true);
    request("TransformEnd");
  }
  for (const NodePtr& p : l.patterns) node(*p, true);
  transform(l.toWorld);
  if (l.node) node(*l.node, true);
  if (l.geometry) {
    Primitive p = *l.geometry;
    p.attributes = nullptr;  // those of the light, already said
    p.toWorld = Transform();
    if (!p.times.empty()) request("MotionBegin", p.times);
    shape(p, p.primvars, nullptr);
    for (const ParameterList& m : p.motion) shape(p, m, &m);
    if (!p.times.empty()) request("MotionEnd");
  }
  request("AttributeEnd");
}

void Writer::camera(const Camera& c, bool primary) {
  if (!primary) request("TransformBegin");
  if (c.projection)
    node(*c.projection, false);
  else
    request("Projection");
  if (c.screenWindow != std::array<float, 4>{}) request("ScreenWindow", c.screenWindow);
  request("Shutter", c.shutter);
  if (c.depthOfField[0] > 0)
    request("DepthOfField", c.depthOfField);
  else
    request("DepthOfField");
  if (c.clipping != std::array<float, 2>{}) request("Clipping", c.clipping);
  request("Identity");
  for (const std::array<double, 6>& plane : c.clippingPlanes) request("ClippingPlane", plane);
  transform(c.worldToCamera);
  begin("Camera");
  word(c.name);
  parameters(c.params);
  end();
  if (!primary) request("TransformEnd");
}

// Each after those it instances; a prototype can be deeper in the list than one that uses it.
void Writer::prototypes(const std::vector<Prototype>& list) {
  std::set<std::string> used;
  for (size_t i = 0; i < list.size(); ++i) {
    std::string name = list[i].name.empty() ? "object" : list[i].name;
    while (!used.insert(name).second) name += "#" + std::to_string(i);
    names_.push_back(name);
  }
  std::vector<char> state(list.size(), 0);  // 1: its parts are on the stack above it; 2: written
  std::vector<size_t> stack;
  for (size_t first = 0; first < list.size(); ++first) {
    stack.push_back(first);
    while (!stack.empty()) {
      const size_t i = stack.back();
      if (state[i] == 0) {
        state[i] = 1;
        for (size_t k = 0; k < list[i].instances.size(); ++k)
          if (const uint32_t part = list[i].instances.prototypeOf(k); part < list.size() && state[part] == 0)
            stack.push_back(part);
        continue;
      }
      stack.pop_back();
      if (state[i] == 2) continue;
      state[i] = 2;
      request("ObjectBegin", names_[i]);
      contents(list[i]);
      request("ObjectEnd");
    }
  }
}

void Writer::scene(const Scene& s) {
  text_ += "##RenderMan RIB-Structure 1.1\nversion 3.04\n";
  request("Option", "ribparse", "string varsubst", std::vector<std::string>{""});  // values stand as they are
  if (s.hasFrame) request("FrameBegin", s.frame);
  ParameterList options = s.options;
  options.erase("ribparse:varsubst");
  grouped("Option", options);
  if (s.resolution[0] > 0 || s.resolution[1] > 0 || s.pixelAspect != 1)
    request("Format", s.resolution[0], s.resolution[1], s.pixelAspect);
  if (s.frameAspect > 0) request("FrameAspectRatio", s.frameAspect);
  request("CropWindow", s.cropWindow);
  request("PixelFilter", s.pixelFilter, s.pixelFilterWidth[0], s.pixelFilterWidth[1]);
  if (s.pixelVariance >= 0) request("PixelVariance", s.pixelVariance);
  if (s.pixelSamples[0] > 0) request("PixelSamples", s.pixelSamples);
  request("Exposure", s.exposure);
  if (s.hider) node(*s.hider, false);
  if (s.integrator) node(*s.integrator, true);
  for (const NodePtr& f : s.sampleFilters) node(*f, true);
  for (const NodePtr& f : s.displayFilters) node(*f, true);
  for (const DisplayChannel& c : s.channels) {
    begin("DisplayChannel");
    word(std::string(nameOf(c.type)) + (c.arrayLength > 1 ? "[" + std::to_string(c.arrayLength) + "] " : " ") +
         c.name);
    parameters(c.params);
    end();
  }
  for (size_t i = 0; i < s.displays.size(); ++i) {
    begin("Display");
    word((i ? "+" : "") + s.displays[i].file);
    word(s.displays[i].driver);
    word(s.displays[i].mode);
    parameters(s.displays[i].params);
    end();
  }
  for (const KeptRequest& k : s.kept) {
    if (k.request == "EditBegin") continue;  // a block whose end is not known any more
    begin(k.request);
    for (const std::string& a : k.args) {
      double v;
      const auto r = std::from_chars(a.data(), a.data() + a.size(), v);
      if (r.ec == std::errc() && r.ptr == a.data() + a.size())
        text_ += " " + a;
      else
        word(a);
    }
    parameters(k.params);
    end();
  }
  for (size_t i = 0; i < s.cameras.size(); ++i) camera(s.cameras[i], i == 0);
  request("WorldBegin");
  for (const auto& [name, space] : s.coordinateSystems) {
    if (name == "world" || name == "camera") continue;
    request("TransformBegin");
    transform(space);
    request("CoordinateSystem", name);
    request("TransformEnd");
  }
  std::set<std::string> handles;
  for (const Light& l : s.classicLights)
    if (l.geometry) {
      lamps_[l.geometry->id] = l.node;
    } else {
      // the block that follows ends, so that objects switch on what shines on them: by handles of one light each
      Light named = l;
      if (!handles.insert(l.node->handle).second) {
        auto renamed = std::make_shared<Node>(*l.node);
        while (!handles.insert(renamed->handle += "_").second) {
        }
        named.node = renamed;
      }
      lightSources_[l.id] = named.node->handle;
      light(named);
    }
  prototypes(s.prototypes);
  contents(s);
  request("WorldEnd");
  if (s.hasFrame) request("FrameEnd");
}

}  // namespace

void writeRib(const Scene& scene, const TextSink& sink) { Writer(sink).scene(scene); }

std::string writeRib(const Scene& scene) {
  std::string text;
  writeRib(scene, [&](std::string_view part) { text += part; });
  return text;
}

}  // namespace kinora::rib
