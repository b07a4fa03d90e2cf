#include "rib/interpreter.h"

#include <cstdlib>
#include <filesystem>
#include <utility>

#include "base/text.h"
#include "rib/archive_search.h"
#include "rib/condition.h"
#include "rib/named_values.h"

namespace kinora::rib {

const Interpreter::Table& Interpreter::table() {
  using I = Interpreter;
  using enum Family;
  static const Table kTable = {
      {"version", {&I::versionRequest, Other}},
      {"Declare", {&I::declareRequest, Control}},
      // blocks
      {"FrameBegin", {&I::frameBegin, Other}},
      {"FrameEnd", {&I::frameEnd, Other}},
      {"WorldBegin", {&I::worldBegin, Other}},
      {"WorldEnd", {&I::worldEnd, Other}},
      {"AttributeBegin", {&I::attributeBegin, Other, true}},
      {"AttributeEnd", {&I::attributeEnd, Other, true}},
      {"TransformBegin", {&I::transformBegin, Other, true}},
      {"TransformEnd", {&I::transformEnd, Other, true}},
      {"SolidBegin", {&I::solidBegin, Other}},
      {"SolidEnd", {&I::solidEnd, Other}},
      {"ObjectBegin", {&I::objectBegin, Other}},
      {"ObjectEnd", {&I::objectEnd, Other}},
      {"ObjectInstance", {&I::objectInstance, Other}},
      {"ResourceBegin", {&I::resourceBegin, Other}},
      {"ResourceEnd", {&I::resourceEnd, Other}},
      {"Resource", {&I::resource, Other}},
      {"MotionBegin", {&I::motionBegin, Control}},
      {"MotionEnd", {&I::motionEnd, Control}},
      {"IfBegin", {&I::ifBegin, Control}},
      {"ElseIf", {&I::elseIf, Control}},
      {"Else", {&I::elseRequest, Control}},
      {"IfEnd", {&I::ifEnd, Control}},
      {"EditBegin", {&I::editBegin, Control}},
      {"EditEnd", {&I::editEnd, Control}},
      // options and cameras
      {"Option", {&I::option, Other}},
      {"Attribute", {&I::attribute, Other, true}},
      {"Format", {&I::format, Other}},
      {"FrameAspectRatio", {&I::frameAspectRatio, Other}},
      {"ScreenWindow", {&I::screenWindow, Other}},
      {"CropWindow", {&I::cropWindow, Other}},
      {"Projection", {&I::projection, Other}},
      {"Clipping", {&I::clipping, Other}},
      {"DepthOfField", {&I::depthOfField, Other}},
      {"Shutter", {&I::shutter, Other}},
      {"Camera", {&I::camera, Other}},
      {"PixelFilter", {&I::pixelFilter, Other}},
      {"PixelSamples", {&I::pixelSamples, Other}},
      {"PixelVariance", {&I::pixelVariance, Other}},
      {"Exposure", {&I::exposure, Other}},
      {"Display", {&I::display, Other}},
      {"DisplayChannel", {&I::displayChannel, Other}},
      {"Hider", {&I::hider, Other}},
      {"Integrator", {&I::integrator, Other}},
      {"SampleFilter", {&I::sampleFilter, Other}},
      {"DisplayFilter", {&I::displayFilter, Other}},
      // shading and the attributes that have their own request
      {"Bxdf", {&I::bxdf, Other, true}},
      {"Pattern", {&I::pattern, Other, true}},
      {"Displace", {&I::displace, Other, true}},
      {"Light", {&I::light, Other}},
      {"LightFilter", {&I::lightFilter, Other}},
      {"Surface", {&I::classicShader, Other, true}},
      {"Displacement", {&I::classicShader, Other, true}},
      {"Deformation", {&I::classicShader, Other}},
      {"Atmosphere", {&I::classicShader, Other}},
      {"Interior", {&I::classicShader, Other}},
      {"Exterior", {&I::classicShader, Other}},
      {"VPSurface", {&I::classicShader, Other}},
      {"VPAtmosphere", {&I::classicShader, Other}},
      {"VPInterior", {&I::classicShader, Other}},
      {"VPExterior", {&I::classicShader, Other}},
      {"LightSource", {&I::lightSource, Other}},
      {"AreaLightSource", {&I::areaLightSource, Other}},
      {"Illuminate", {&I::illuminate, Other}},
      {"Color", {&I::color, Other, true}},
      {"Opacity", {&I::opacity, Other, true}},
      {"TextureCoordinates", {&I::textureCoordinates, Other, true}},
      {"ShadingRate", {&I::shadingRate, Other, true}},
      {"ShadingInterpolation", {&I::shadingInterpolation, Other, true}},
      {"Matte", {&I::matte, Other, true}},
      {"Sides", {&I::sides, Other, true}},
      {"Orientation", {&I::orientation, Other, true}},
      {"ReverseOrientation", {&I::reverseOrientation, Other, true}},
      {"Basis", {&I::basis, Other, true}},
      {"TrimCurve", {&I::trimCurve, Other}},
      // transforms
      {"Identity", {&I::transformRequest, Transform}},
      {"Transform", {&I::transformRequest, Transform}},
      {"ConcatTransform", {&I::transformRequest, Transform}},
      {"Translate", {&I::transformRequest, Transform}},
      {"Rotate", {&I::transformRequest, Transform}},
      {"Scale", {&I::transformRequest, Transform}},
      {"Skew", {&I::transformRequest, Transform}},
      {"Perspective", {&I::transformRequest, Transform}},
      {"CoordinateSystem", {&I::coordinateSystem, Other}},
      {"ScopedCoordinateSystem", {&I::scopedCoordinateSystem, Other}},
      {"CoordSysTransform", {&I::coordSysTransform, Other}},
      // geometry
      {"Sphere", {&I::geometryRequest, Geometry}},
      {"Cone", {&I::geometryRequest, Geometry}},
      {"Cylinder", {&I::geometryRequest, Geometry}},
      {"Hyperboloid", {&I::geometryRequest, Geometry}},
      {"Paraboloid", {&I::geometryRequest, Geometry}},
      {"Disk", {&I::geometryRequest, Geometry}},
      {"Torus", {&I::geometryRequest, Geometry}},
      {"Polygon", {&I::geometryRequest, Geometry}},
      {"GeneralPolygon", {&I::geometryRequest, Geometry}},
      {"PointsPolygons", {&I::geometryRequest, Geometry}},
      {"PointsGeneralPolygons", {&I::geometryRequest, Geometry}},
      {"Patch", {&I::geometryRequest, Geometry}},
      {"PatchMesh", {&I::geometryRequest, Geometry}},
      {"NuPatch", {&I::geometryRequest, Geometry}},
      {"SubdivisionMesh", {&I::geometryRequest, Geometry}},
      {"HierarchicalSubdivisionMesh", {&I::geometryRequest, Geometry}},
      {"Curves", {&I::geometryRequest, Geometry}},
      {"Points", {&I::geometryRequest, Geometry}},
      {"Blobby", {&I::geometryRequest, Geometry}},
      {"Volume", {&I::geometryRequest, Geometry}},
      {"Geometry", {&I::geometryRequest, Geometry}},
      // archives
      {"ReadArchive", {&I::readArchive, Other}},
      {"ArchiveBegin", {&I::archiveBegin, Control}},
      {"ArchiveEnd", {&I::archiveEnd, Control}},
      {"Procedural", {&I::procedural, Other, true}},
      {"Procedural2", {&I::procedural2, Other, true}},
      // read, kept and reported: nothing renders them
      {"Bound", {&I::keep, Other}},
      {"ClippingPlane", {&I::clippingPlane, Other}},
      {"ColorSamples", {&I::keep, Other}},
      {"ConnectShaderLayers", {&I::keep, Other}},
      {"Detail", {&I::detail, Other}},
      {"DetailRange", {&I::detailRange, Other}},
      {"EnableLightFilter", {&I::keep, Other}},
      {"ErrorHandler", {&I::keep, Other}},
      {"GeometricApproximation", {&I::keep, Other}},
      {"GeometricRepresentation", {&I::keep, Other}},
      {"Imager", {&I::imager, Other}},
      {"MakeBrickMap", {&I::keep, Other}},
      {"MakeBump", {&I::keep, Other}},
      {"MakeCubeFaceEnvironment", {&I::keep, Other}},
      {"MakeLatLongEnvironment", {&I::keep, Other}},
      {"MakeShadow", {&I::keep, Other}},
      {"MakeTexture", {&I::keep, Other}},
      {"Quantize", {&I::keep, Other}},
      {"RelativeDetail", {&I::relativeDetail, Other}},
      {"ShaderLayer", {&I::keep, Other}},
      {"System", {&I::keep, Other}},
      {"VolumePixelSamples", {&I::keep, Other}},
  };
  return kTable;
}

bool Interpreter::isRequest(std::string_view word) { return table().contains(word); }

Interpreter::Interpreter(Diagnostics& messages, ReadOptions options, RibReader::OnWorld onWorld)
    : messages_(messages), read_(std::move(options)), onWorld_(std::move(onWorld)) {
  state_.attributes = std::make_shared<scene::Attributes>();
  dirmap_ = read_.dirmap;
}

bool Interpreter::readFile(const std::string& given) {
  std::string why;
  const std::string path = sceneIn(given, why);
  if (path.empty()) {
    report(Severity::Error, "RIB-ZIP", {}, "'" + given + "' " + why, "it is skipped",
           "name a member: " + given + "!FILE.rib");
    return false;
  }
  auto source = openFile(path, why);
  if (!source) {
    const bool isDirectory = why == "is a directory";
    report(Severity::Error, isDirectory ? "RIB-DIRECTORY" : "RIB-OPEN", {},
           "'" + path + "' cannot be read: it " + (isDirectory ? why : "gives \"" + why + "\""), "it is skipped",
           isDirectory ? "name a RIB file" : "check the name and the permissions");
    return false;
  }
  mainDirectory_ = folderOf(given);
  Source s;
  s.lexer = std::make_unique<Lexer>(std::move(source), path == "-" ? "stdin" : path, messages_, &isRequest);
  std::error_code failed;
  const auto canonical = std::filesystem::weakly_canonical(path, failed);
  s.identity = failed ? path : canonical.string();
  push(std::move(s));
  const bool any = sources_.front().anyRequest;
  sources_.clear();
  return any;
}

bool Interpreter::readText(const std::string& name, std::string text) {
  Source s;
  s.lexer = std::make_unique<Lexer>(openText(std::move(text)), name, messages_, &isRequest);
  s.identity = name;
  push(std::move(s));
  const bool any = sources_.front().anyRequest;
  sources_.clear();
  return any;
}

bool Interpreter::push(Source s) {
  const bool outermost = sources_.empty();
  s.conditions = conditions_.size();
  s.unopenedIfs = unopenedIfs_;
  sources_.push_back(std::move(s));
  if (outermost) run();
  return true;
}

// Archives are sources on a stack of our own, so that their nesting never nests the C++ stack. The outermost source
// stays on it when it ends, for its caller to look at.
void Interpreter::run() {
  for (;;) {
    Source& s = sources_.back();
    bool more = false;
    if (read_.stop && read_.stop->load(std::memory_order_relaxed)) {
      more = false;  // archives end one after the other
    } else if (s.lexer) {
      more = s.lexer->readRequest(request_);
    } else if (s.at < s.recorded->size()) {
      const Request& r = (*s.recorded)[s.at++];
      request_.clear();
      request_.name = r.name;
      request_.pos = r.pos;
      for (size_t i = 0; i < r.count; ++i) request_.add(r.args[i].line) = r.args[i];
      more = true;
    }
    if (more) {
      s.anyRequest = true;
      dispatch(request_);
      continue;
    }
    // first what this hands over now, which may be an archive
    if (sources_.size() > 1 && closeWhatWaits("it ends with the archive")) continue;
    if (s.lexer) bytes_ += s.lexer->bytesRead();
    if (!s.anyRequest && s.lexer)
      report(sources_.size() + ancestors_.size() == 1 ? Severity::Error : Severity::Warning, "RIB-EMPTY",
             {s.lexer->pos().file, 0}, "the file holds no request", "nothing is read from it");
    if (sources_.size() == 1) return;
    if (conditions_.size() > s.conditions)  // one message, however many they are
      report(Severity::Error, "RIB-NESTING", conditions_.back().pos, "IfBegin is not closed in its archive",
             "it ends with the archive");
    unopenedIfs_ = s.unopenedIfs;
    while (conditions_.size() > s.conditions) {
      inactive_ -= !conditions_.back().active;
      conditions_.pop_back();
    }
    if (s.restore) state_ = std::move(*s.restore);
    sources_.pop_back();
  }
}

void Interpreter::dispatch(Request& r) {
  if (recording_) {
    if (r.name == "ArchiveBegin") ++recordingDepth_;
    if (r.name != "ArchiveEnd" || --recordingDepth_ > 0) {
      Request copy = r;
      copy.args.resize(copy.count);
      if (copy.name != "MotionBegin")
        for (Argument& a : copy.args)
          if (a.exact.size() > Argument::kExactKept)
            a.exact = std::vector<double>(a.exact.begin(), a.exact.begin() + Argument::kExactKept);
      recording_->push_back(std::move(copy));
      return;
    }
  }
  const auto it = table().find(r.name);
  const bool isCondition = r.name == "IfBegin" || r.name == "ElseIf" || r.name == "Else" || r.name == "IfEnd";
  if (inactive_ > 0 && !isCondition) return;
  if (inEdit_ && r.name != "EditEnd") {
    // an edit that is never closed must not swallow a world
    if (r.name != "WorldBegin" && r.name != "WorldEnd" && r.name != "EditBegin") return;
    if (r.name != "EditBegin")
      report(Severity::Error, "RIB-NESTING", editPos_, "EditBegin is not closed", "it ends before " + r.name);
    inEdit_ = false;
  }
  if (it == table().end()) {
    if (unknownNames_.insert(r.name).second && unknownNames_.size() < 1000)
      report(Severity::Warning, "RIB-UNKNOWN-REQUEST", r.pos, "no request is called '" + r.name.substr(0, 60) + "'",
             "it is skipped with its arguments", "names are case-sensitive; a quote or '#' may be missing before it");
    return;
  }
  if (!it->second.isLocal && it->second.family != Family::Transform && it->second.family != Family::Geometry)
    surroundings_ = nullptr;
  if (marker_) substituteStrings(r);
  if (!dirmap_.empty()) mapDirectories(r);
  if (inMotion_ && it->second.family != Family::Control) {
    if (r.name == "FrameEnd" || r.name == "WorldEnd") {
      motionEnd(r);
    } else {
      Request key = std::move(r);
      key.args.resize(key.count);
      for (Argument& a : key.args)
        if (a.exact.size() > Argument::kExactKept)
          std::vector<double>(a.exact.begin(), a.exact.begin() + Argument::kExactKept).swap(a.exact);
      motionRequests_.push_back(std::move(key));
      r = Request();
      return;
    }
  }
  (this->*it->second.handler)(r);
}

void Interpreter::execute(Request& r) {
  const auto it = table().find(r.name);
  if (it != table().end()) (this->*it->second.handler)(r);
}

void Interpreter::substituteStrings(Request& r) {
  const auto look = [this](std::string_view n) { return lookUp(n); };
  for (size_t i = 0; i < r.count; ++i)
    for (std::string& s : r.args[i].strings)
      if (s.find(marker_) != std::string::npos) s = substitute(s, marker_, bareMarker_, look);
}

// Whatever begins as a mapped folder does is a path of another machine; search paths hold several.
void Interpreter::mapDirectories(Request& r) {
  const bool isList =
      r.name == "Option" && r.count > 0 && r.args[0].isString() && r.args[0].strings[0] == "searchpath";
  for (size_t i = 0; i < r.count; ++i) {
    if (isList && i > 0 && r.args[i - 1].isString() && r.args[i - 1].strings[0].ends_with("dirmap")) continue;
    for (std::string& s : r.args[i].strings) {
      if (!isList) {
        s = mapDirectory(s, dirmap_);
        continue;
      }
      std::string mapped;
      for (size_t at = 0; at <= s.size();) {
        const size_t colon = std::min(s.find(':', at), s.size());
        mapped += (at ? ":" : "") + mapDirectory(s.substr(at, colon - at), dirmap_);
        at = colon + 1;
      }
      s = mapped;
    }
  }
}

// "user:pass", "Option:limits:gridsize", "Frame", or a variable of the environment, in this order of trust: attribute,
// option, what holds where nothing was said. Bare names are those of users and of requests.
std::optional<std::string> Interpreter::lookUp(std::string_view name) const {
  const bool optionOnly = name.starts_with("Option:"), attributeOnly = name.starts_with("Attribute:");
  if (optionOnly) name.remove_prefix(7);
  if (attributeOnly) name.remove_prefix(10);
  const bool isBare = name.find(':') == std::string_view::npos;
  const std::string asUser = "user:" + std::string(name), asRequest = (isBare ? "Ri:" : "") + std::string(name);
  const scene::Scene& options = world_ ? *world_ : frame_.options;
  const scene::Camera& camera = world_ && !world_->cameras.empty() ? world_->cameras[0] : frame_.camera;
  const bool isMirrored = std::as_const(state_.ctm).matrices[0].determinant() < 0;
  for (const std::string_view n : {name, std::string_view(asUser), std::string_view(asRequest)}) {
    if (!optionOnly) {
      if (auto v = attributeValue(n, *state_.attributes, isMirrored)) return v;
      // objects begin without attributes, but may ask for those around them
      for (size_t i = blocks_.size(); i-- > 0;)
        if (blocks_[i].kind == BlockKind::Object)
          if (auto v = attributeValue(n, *blocks_[i].state->attributes, isMirrored)) return v;
    }
    if (!attributeOnly)
      if (auto v = optionValue(n, options, camera)) return v;
  }
  if (isBare && !optionOnly && !attributeOnly)
    if (const char* v = std::getenv(std::string(name).c_str())) return std::string(v);
  if (!optionOnly)
    if (auto v = usualAttribute(asRequest)) return v;
  return attributeOnly ? std::nullopt : usualOption(asRequest);
}

// One that is left out: nobody after the reader says so again. The codes are of the families that --strict counts.
void Interpreter::reportProcedural(const Request& r) {
  const std::string kind = r.args[0].isString() ? r.args[0].strings[0].substr(0, 60) : std::string();
  const bool isSecond = r.name == "Procedural2",
             isObject = kind == "DynamicLoad" || (isSecond && kind == "DynamicLoad2");
  if (!isObject && kind != "RunProgram" && !(isSecond && kind == "RunProgram2")) {
    report(Severity::Warning, "PLUGIN-PROCEDURAL", r.pos, "no kind of " + r.name + " is called '" + kind + "'",
           "what it would draw is left out; the request is kept in the scene description",
           "there are DelayedReadArchive, RunProgram and DynamicLoad, of Procedural2 with a 2 at the end");
    return;
  }
  // Procedural says which by its second argument, Procedural2 by a parameter
  std::string which;
  for (size_t k = 1; isSecond && k + 1 < r.count && which.empty(); ++k)
    if (r.args[k].isString() && r.args[k].strings[0].ends_with(isObject ? "dsoname" : "filename") &&
        !r.args[k + 1].strings.empty())
      which = r.args[k + 1].strings[0];
  if (!isSecond && r.count > 1 && !r.args[1].strings.empty()) which = r.args[1].strings[0];
  report(Severity::Warning, "ASSET-PROGRAM-REFUSED", r.pos,
         std::string(isObject ? "the shared object '" : "the program '") + which.substr(0, 200) + "' of a " + kind +
             (isObject ? " is not loaded" : " is not run"),
         "what it would draw is left out; the request is kept in the scene description",
         read_.allowExec
             ? "shared objects are run by kinora-procedural, which stands beside kinora"
             : "--allow-exec lets scenes run programs and shared objects: only for scenes that you trust");
}

void Interpreter::reportKept(const Request& r) {
  // the shape of an area light is that of what stands in for the light, and not seen otherwise
  if (r.name == "Geometry" && state_.emitter && state_.emitter->node->kind == "AreaLightSource") return;
  if (r.name.starts_with("Procedural")) return reportProcedural(r);
  static constexpr std::string_view kShaders[] = {"Imager",   "Atmosphere", "Displacement",
                                                  "Interior", "Exterior",   "Deformation"};
  std::string who = r.name;
  if (std::find(std::begin(kShaders), std::end(kShaders), r.name) != std::end(kShaders) && r.count > 0 &&
      r.args[0].isString())
    who += " '" + r.args[0].strings[0].substr(0, 60) + "'";
  if (!keptNames_.insert(who).second) return;
  report(Severity::Warning, "RIB-KEPT-" + upperCase(r.name), r.pos, who + " is not rendered yet",
         "it is kept in the scene description without effect");
}

void Interpreter::keep(Request& r) {
  reportKept(r);
  keepQuietly(r);
}

void Interpreter::keepQuietly(Request& r) {
  scene::KeptRequest k;
  k.request = r.name;
  k.pos = r.pos;
  size_t i = 0;
  // positional arguments as text; what looks like a parameter list as one
  const auto isToken = [&](const Argument& a) {
    return i > 0 && a.isString() && !a.isArray && declarations_.find(a.strings[0]) != nullptr;
  };
  for (; i < r.count && !(i + 1 < r.count && isToken(r.args[i])); ++i) {
    const Argument& a = r.args[i];
    for (const std::string& s : a.strings) k.args.push_back(s);
    if (a.kind == Argument::Kind::Strings) continue;
    for (size_t n = 0; n < a.size(); ++n)
      k.args.push_back(a.isInteger ? plainText(a.ints[n]) : plainText(a.floats[n]));
  }
  if (i < r.count) k.params = parameters(r, i, Use::Classic);
  (world_ ? *world_ : frame_.options).kept.push_back(std::move(k));
}

scene::Attributes& Interpreter::edit() {
  if (state_.attributes.use_count() > 1) state_.attributes = std::make_shared<scene::Attributes>(*state_.attributes);
  return *state_.attributes;
}

bool Interpreter::closeWhatWaits(const char* endsWith) {
  const bool isAny = recording_ || inMotion_ || inEdit_;
  if (recording_) {
    report(Severity::Error, "RIB-NESTING", recordingPos_, "ArchiveBegin \"" + recordingName_ + "\" is not closed",
           endsWith);
    Request end;
    end.name = "ArchiveEnd";
    archiveEnd(end);
  }
  if (inMotion_) {
    report(Severity::Error, "RIB-NESTING", motionPos_, "MotionBegin is not closed", endsWith);
    Request end;
    end.name = "MotionEnd";
    motionEnd(end);
  }
  if (inEdit_) report(Severity::Error, "RIB-NESTING", editPos_, "EditBegin is not closed", endsWith);
  inEdit_ = false;
  return isAny;
}

void Interpreter::closeAll(size_t blocksLeft) {
  static const char* const kNames[] = {"AttributeBegin", "TransformBegin", "FrameBegin",   "WorldBegin",
                                       "SolidBegin",     "ObjectBegin",    "ResourceBegin"};
  closeWhatWaits("it ends with the file");
  if (!conditions_.empty())  // one message, however many they are
    report(Severity::Error, "RIB-NESTING", conditions_.back().pos, "IfBegin is not closed", "it ends with the file");
  conditions_.clear();
  unopenedIfs_ = 0;
  inactive_ = 0;
  while (blocks_.size() > blocksLeft) {
    report(Severity::Error, "RIB-NESTING", blocks_.back().pos,
           std::string(kNames[int(blocks_.back().kind)]) + " is not closed", "it ends with the file");
    leave();
  }
}

void Interpreter::finish() {
  closeAll(0);
  if (outsideWorld_ > 0)
    report(Severity::Warning, "RIB-OUTSIDE-WORLD", {},
           std::to_string(outsideWorld_) + " primitives and lights stand outside WorldBegin ... WorldEnd",
           "they are ignored", "read the file by ReadArchive from a scene that has a world");
  if (worlds_ == 0)
    report(Severity::Error, "RIB-NO-WORLD", {}, "no WorldBegin ... WorldEnd was read", "there is nothing to render");
}

}  // namespace kinora::rib
