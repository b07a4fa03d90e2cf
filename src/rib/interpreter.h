// What the requests mean: the graphics state, its blocks, and a handler for each request. Used by reader.cpp alone.
// The handlers stand in files named after their families: blocks, options, transforms, shading, geometry, archives.
#pragma once
#include <atomic>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <unordered_map>
#include <unordered_set>
#include <utility>
#include <vector>

#include "base/diagnostics.h"
#include "base/digest.h"
#include "base/memory.h"
#include "rib/declarations.h"
#include "rib/lexer.h"
#include "rib/light_scan.h"
#include "rib/no_effect.h"
#include "rib/reader.h"
#include "rib/request.h"
#include "scene/procedural.h"
#include "scene/scene.h"

namespace kinora::rib {

using Recorded = std::vector<Request>;

// Requests inside MotionBegin: transforms and geometry have one key each; of all others the first counts.
enum class Family : uint8_t { Other, Transform, Geometry, Control };

class Interpreter {
 public:
  Interpreter(Diagnostics& messages, ReadOptions options, RibReader::OnWorld onWorld);

  bool readFile(const std::string& given);
  bool readText(const std::string& name, std::string text);
  void finish();
  uint64_t bytesRead() const { return bytes_; }
  size_t worlds() const { return worlds_; }
  const std::shared_ptr<const scene::ProceduralSources>& procedurals() const { return doneProcedurals_; }
  static bool isRequest(std::string_view word);

 private:
  using Handler = void (Interpreter::*)(Request&);
  struct Entry {
    Handler handler;
    Family family;
    bool isLocal = false;  // changes nothing of Surroundings
  };
  using Table = std::unordered_map<std::string_view, Entry>;
  static const Table& table();

  // ---- state
  struct LightFilter {
    scene::NodePtr node;
    scene::Transform toWorld;
  };
  struct State {
    std::shared_ptr<scene::Attributes> attributes;
    scene::Transform ctm;  // world to camera before WorldBegin, object to world after it
    std::vector<LightFilter> lightFilters;
    std::shared_ptr<const scene::Light> emitter;       // PxrMeshLight or AreaLightSource that waits for geometry
    std::shared_ptr<const scene::ParameterList> trim;  // TrimCurve
    // Terminals that read patterns not declared yet: resolved when the first object uses them.
    scene::NodePtr lateBxdf, lateDisplacement;
  };
  using NodeMap = std::unordered_map<std::string, scene::NodePtr>;
  enum class BlockKind : uint8_t { Attribute, Transform, Frame, World, Solid, Object, Resource };
  struct FrameState {
    scene::Scene options;                                  // a scene without objects
    scene::Camera camera;                                  // what the camera requests said so far
    std::map<std::string, scene::Transform> cameraSpaces;  // named before WorldBegin: that space to camera
    std::vector<scene::Light> cameraLights;                // declared before WorldBegin: they move with the camera
  };
  struct Block {
    BlockKind kind;
    SourcePos pos;
    std::unique_ptr<State> state;  // null: only the transform comes back
    scene::Transform ctm;
    std::unique_ptr<FrameState> frame;  // FrameBegin's
    std::shared_ptr<NodeMap> nodes;     // declared in this block, by handle; see remember()
    uint32_t solid = 0;                 // the one that was open before
  };
  struct Source {
    std::unique_ptr<Lexer> lexer;              // a file, or
    std::shared_ptr<const Recorded> recorded;  // an inline archive
    size_t at = 0;
    std::string identity;  // to find archives that read themselves
    size_t conditions = 0;
    size_t unopenedIfs = 0;
    std::unique_ptr<State> restore;  // a procedural leaves the attributes and the transform as they were
    bool anyRequest = false;
  };
  struct Condition {
    bool taken = false;   // one of the branches was true
    bool active = false;  // this branch is
    bool sawElse = false;
    SourcePos pos;
  };

  // What archives that are read later see of all that was said before their request, but for the graphics state:
  // shared by those between which none of it changed.
  struct Surroundings {
    ReadOptions read;
    Declarations declarations;
    FrameState frame;
    scene::Scene world;  // its options, cameras and coordinate systems
    std::set<std::string> onlyScoped;
    std::map<std::string, scene::NetworkPtr> materials;
    std::map<std::string, State> resources;
    std::unordered_map<std::string, uint32_t> lightSourceOf, prototypeByHandle;
    std::set<scene::PrimitivePtr> ownFaceSets;
    std::unordered_map<std::string, std::shared_ptr<const Recorded>> inlineArchives;
    std::vector<std::pair<std::string, std::string>> dirmap;
    std::string mainDirectory;
    char marker;
    bool bareMarker;
    // Objects said so far; they are all there once the world is.
    size_t prototypeCount;
    std::shared_ptr<const std::vector<scene::Prototype>> prototypes;
    std::shared_ptr<std::atomic<int>> archiveReads;
    Digest said;  // of what of it no other part of the description holds
  };
  class DelayedArchive;  // procedurals.cpp

  // ---- interpreter.cpp: the loop
  bool push(Source s);
  void run();
  void dispatch(Request& r);
  void execute(Request& r);
  void substituteStrings(Request& r);
  void mapDirectories(Request& r);
  std::optional<std::string> lookUp(std::string_view name) const;
  void report(Severity s, std::string code, const SourcePos& pos, std::string what, std::string done = {},
              std::string advice = {}) {
    messages_.report({s, std::move(code), pos, std::move(what), std::move(done), std::move(advice)});
  }
  void keep(Request& r);         // into Scene::kept, with a report
  void keepQuietly(Request& r);  // where something stands in for it
  void tellOfNoEffect(Where where, const std::string& name, const scene::Parameter& p, const SourcePos& pos);
  void reportProcedural(const Request& r);
  void reportKept(const Request& r);                        // once per name, of shaders once per shader
  scene::Attributes& edit();                                // the current attributes, no longer shared
  scene::Attributes& edit(scene::Attributes::Given what) {  // ... of which this is being set
    scene::Attributes& a = edit();
    a.given |= what;
    return a;
  }
  bool inWorldOrObject() const { return world_ || !openObjects_.empty(); }

  // ---- arguments.cpp: values out of requests
  class Cursor;
  // Classic: shaders and displays whose bare names are theirs to know, so that guessing a type is no repair.
  enum class Use : uint8_t { Node, Classic, Option, Attribute, Primitive };
  scene::ParameterList parameters(Request& r, size_t first, Use use);
  bool convert(Request& r, Argument& a, const Declaration& d, scene::Parameter& p, Use use);
  std::optional<Declaration> guess(const Request& r, const std::string& token, const Argument& a, Use use);
  void badArguments(const Request& r, const std::string& wanted);
  // `count` finite numbers, or a message and false.
  bool numbers(Cursor& c, size_t count, double* out, const char* wanted);

  // ---- blocks.cpp
  void open(BlockKind kind, const Request& r);
  void close(BlockKind kind, const Request& r);
  void closeInner(std::vector<size_t>& inner, BlockKind kind, const Request& r);
  void leave();  // the innermost block
  void versionRequest(Request&);
  void declareRequest(Request&);
  void frameBegin(Request&);
  void frameEnd(Request&);
  void worldBegin(Request&);
  void worldEnd(Request&);
  void attributeBegin(Request&);
  void attributeEnd(Request&);
  void transformBegin(Request&);
  void transformEnd(Request&);
  void solidBegin(Request&);
  void solidEnd(Request&);
  // The solid that a surface here bounds a part of.
  uint32_t solidHere(const SourcePos& pos);
  std::vector<scene::Solid>& solidsHere() {
    return openObjects_.empty() ? world_->solids : prototypes_[openObjects_.back()].solids;
  }
  void objectBegin(Request&);
  void objectEnd(Request&);
  void objectInstance(Request&);
  void resourceBegin(Request&);
  void resourceEnd(Request&);
  void resource(Request&);
  void motionBegin(Request&);
  void motionEnd(Request&);
  void ifBegin(Request&);
  Condition* endPart(Request&, const std::string& name);
  void elseIf(Request&);
  void elseRequest(Request&);
  void ifEnd(Request&);
  void editBegin(Request&);
  void editEnd(Request&);
  void finishWorld();
  void closeAll(size_t blocksLeft);  // what is still open, with messages
  // What keeps requests from being executed until its end: inline archives, motion blocks, edits. False: none is open.
  bool closeWhatWaits(const char* endsWith);
  bool condition(Request& r);
  bool hasOwnCondition() const;

  // ---- options.cpp
  bool optionsAllowed(const Request& r);
  void option(Request&);
  void attribute(Request&);
  void format(Request&);
  void frameAspectRatio(Request&);
  void screenWindow(Request&);
  void cropWindow(Request&);
  void projection(Request&);
  void clipping(Request&);
  void clippingPlane(Request&);
  void depthOfField(Request&);
  void shutter(Request&);
  void camera(Request&);
  void pixelFilter(Request&);
  void pixelSamples(Request&);
  void pixelVariance(Request&);
  void exposure(Request&);
  void display(Request&);
  void displayChannel(Request&);
  void hider(Request&);
  void integrator(Request&);
  void sampleFilter(Request&);
  void displayFilter(Request&);
  void imager(Request&);
  void applyRiOptions(const scene::ParameterList& p);
  void useDirmap(const Request* r);

  // ---- shading.cpp
  scene::NodePtr node(Request& r, bool hasHandle, Use use = Use::Node);
  const scene::NodePtr* findNode(const std::string& handle) const;
  void remember(const scene::NodePtr& n);
  enum class Missing : uint8_t { Stop, Drop, Report };  // at a reference that leads nowhere
  // False when it stopped; the network is then not usable.
  bool gather(scene::NodePtr& terminal, std::vector<scene::NodePtr>& upstream, Missing missing);
  scene::NetworkPtr bind(const scene::NodePtr& terminal, scene::NodePtr& late);
  std::shared_ptr<const scene::Attributes> attributesInUse();
  void bxdf(Request&);
  void pattern(Request&);
  void displace(Request&);
  void light(Request&);
  void lightFilter(Request&);
  void classicShader(Request&);
  void lightSource(Request&);
  void areaLightSource(Request&);
  void illuminate(Request&);
  void color(Request&);
  void opacity(Request&);
  void textureCoordinates(Request&);
  void shadingRate(Request&);
  void shadingInterpolation(Request&);
  void matte(Request&);
  void sides(Request&);
  void orientation(Request&);
  void reverseOrientation(Request&);
  void basis(Request&);
  void trimCurve(Request&);
  void setOrientation(scene::Attributes::Orientation o);
  void addLight(scene::Light l);
  void switchLightSource(uint32_t id, bool on);

  // ---- detail.cpp
  void detail(Request&);
  void detailRange(Request&);
  void relativeDetail(Request&);

  // ---- transforms.cpp
  void transformRequest(Request&);
  void applyTransforms(std::vector<Request>& keys, const std::vector<double>& times);
  bool matrixOf(const Request& r, scene::Matrix& m, bool& replaces);
  void coordinateSystem(Request&);
  void scopedCoordinateSystem(Request&);
  void addScopedSpace(const std::string& name);  // beside those of the scope
  void coordSysTransform(Request&);

  // ---- geometry.cpp
  void geometryRequest(Request&);
  void applyGeometry(std::vector<Request>& keys, const std::vector<double>& times);
  std::optional<scene::Primitive> primitive(Request& r);
  void emit(scene::Primitive p);
  void reportNoFace(int face, size_t faces, const std::string& request, const SourcePos& pos);
  scene::AttributesPtr withoutFaceSet(const scene::AttributesPtr& attributes);
  // The object, or one like it whose meshes have those faces alone that an instance's "shade:faceset" names: all that
  // named none of their own, in the objects within it too (attributes that are set inside come first, RISpec 5.9).
  uint32_t withFaces(uint32_t object, const std::vector<int>& faces, const Request& r);

  // ---- archives.cpp
  void readArchive(Request&);
  void archiveBegin(Request&);
  void archiveEnd(Request&);
  void procedural(Request&);
  void procedural2(Request&);
  // ---- procedurals.cpp
  // What a procedural reads: the file of an archive, or a program or shared object and the data for it.
  struct Delayed {
    std::string kind;  // of Procedural: DelayedReadArchive, RunProgram, DynamicLoad
    std::vector<std::string> data;
    std::vector<double> bound;    // 6; empty: none
    std::string parameters = {};  // of the Procedural2 of a shared object: its list, as RIB
    bool isObject() const { return kind == "DynamicLoad"; }
    bool isProgram() const { return kind == "RunProgram" || isObject(); }
  };
  // False where it must be read now: its bound is none, or what it says belongs to what is open around it.
  bool delay(const Delayed& what, const Request& r);
  // Whether an archive, or one that it reads, says a light. Files without the word are not interpreted.
  bool holdsLights(const DelayedArchive& archive, const scene::Primitive& as, const std::string& name,
                   const Request& r);
  std::shared_ptr<const Surroundings> surroundings();
  const Digest& digestOf(const std::shared_ptr<NodeMap>& nodes);
  // Takes over objects of archives that wait, one archive after the other, until one of this name is known; false: none
  // has it. What else they hold still waits.
  bool findInDelayed(const std::string& handle);
  void readNamedArchive(const std::string& name, const Request& r, bool isProcedural = false);
  void readProgram(const Delayed& what, const Request& r);
  bool runs(std::string_view kind) const;  // whether procedurals of that kind are run here
  // Messages where not.
  bool mayReadAnother(const std::string& name, const Request& r);
  bool readsItself(const std::string& identity, const std::string& what, const Request& r);
  std::string findArchive(const std::string& name, const std::string& including) const;

  Diagnostics& messages_;
  ReadOptions read_;
  RibReader::OnWorld onWorld_;
  Declarations declarations_;
  uint64_t bytes_ = 0;
  size_t worlds_ = 0;

  std::vector<Source> sources_;
  Request request_;

  State state_;
  std::shared_ptr<NodeMap> outermostNodes_ = std::make_shared<NodeMap>();
  std::map<std::string, scene::NetworkPtr> materials_;  // by plug-in, handle and __materialid
  std::vector<Block> blocks_;
  size_t tooDeep_ = 0;  // blocks begun beyond the limit, not opened
  FrameState frame_;
  std::optional<scene::Scene> world_;
  // Coordinate systems of the world that a scope alone named: there for patterns, which know no scopes.
  std::set<std::string> onlyScoped_;
  size_t worldSources_ = 0;                  // how many files were being read when it began
  std::vector<size_t> innerWorlds_;          // the same of worlds that archives began inside it
  std::vector<size_t> innerFrames_;          // ... and of frames
  MemoryHold held_{MemoryUse::Description};  // of what was read and not handed over yet
  uint32_t nextId_ = 1;
  size_t outsideWorld_ = 0;
  std::map<std::string, State> resources_;
  std::unordered_map<std::string, uint32_t> lightSourceOf_;  // LightSource by handle, the one declared last

  std::vector<scene::Prototype> prototypes_;
  std::unordered_map<std::string, uint32_t> prototypeByHandle_;
  // In an archive that is read later the first ones are empty there, and are in the world: in the interpreter that
  // still reads it, or what that left.
  size_t outerPrototypeCount_ = 0;
  const Interpreter* outer_ = nullptr;
  const std::vector<scene::Prototype>* outerPrototypes_ = nullptr;
  const scene::Prototype& prototypeAt(uint32_t i) const {
    if (i >= outerPrototypeCount_) return prototypes_[i];
    return outer_ ? outer_->prototypeAt(i) : (*outerPrototypes_)[i];
  }
  std::vector<uint32_t> openObjects_;
  std::set<scene::PrimitivePtr> ownFaceSets_;  // meshes of objects that sets of instances do not reach
  std::map<std::pair<uint32_t, std::vector<int>>, uint32_t> withFaces_;
  std::shared_ptr<const scene::Light> lampsOf_;  // the last light that had objects for its shapes
  std::map<uint32_t, uint32_t> lamps_;           // ... and what was made of these objects
  std::pair<scene::AttributesPtr, scene::AttributesPtr> lastWithoutFaceSet_;  // of, and what was made of it
  uint32_t solid_ = 0;  // the innermost open one of the world or the object, from 1; 0: none

  bool inMotion_ = false, isMotionCut_ = false;  // cut: its times were not all usable
  std::vector<double> motionTimes_;
  std::vector<Request> motionRequests_;
  SourcePos motionPos_;

  std::vector<Condition> conditions_;
  size_t unopenedIfs_ = 0;  // inside the deepest one that is allowed
  size_t inactive_ = 0;     // conditions that are not active
  bool inEdit_ = false;
  SourcePos editPos_;
  char marker_ = '$';        // Option "ribparse" "varsubst"
  bool bareMarker_ = false;  // asked for by the scene: "$name" besides "${name}"

  std::shared_ptr<Recorded> recording_;
  std::string recordingName_;
  SourcePos recordingPos_;
  size_t recordingDepth_ = 0;
  std::unordered_map<std::string, std::shared_ptr<const Recorded>> inlineArchives_;
  std::vector<std::string> archivePath_;  // the scene's search path, expanded
  std::string mainDirectory_;
  std::vector<std::pair<std::string, std::string>> dirmap_;  // of the command line and the scene
  std::shared_ptr<std::atomic<int>> archiveReads_ = std::make_shared<std::atomic<int>>(0);
  // of archives that are read later
  std::vector<std::string> ancestors_;  // identities of what was open around the request of this one
  std::vector<std::pair<std::string, std::string>> filesRead_;
  std::vector<std::pair<std::string, Digest>> programsRun_;          // by command, what they printed
  std::shared_ptr<scene::ProceduralSources> procedurals_;            // of the world that is open
  std::shared_ptr<const scene::ProceduralSources> doneProcedurals_;  // of the last one that was closed
  std::shared_ptr<std::vector<scene::Prototype>> worldPrototypes_;   // filled when the world is closed
  // Of maps that sources hold, so that they stay what they are.
  std::unordered_map<const NodeMap*, std::pair<std::shared_ptr<const NodeMap>, Digest>> nodeDigests_;
  size_t lookedInto_ = 0;                             // primitives of the world that findInDelayed() is done with
  std::shared_ptr<const Surroundings> surroundings_;  // as they are now; null: not made
  // Lights in archives that would wait. What was found is kept by file for the whole description; null: nobody looks.
  struct LightSearch {
    std::unordered_map<std::string, Mentions> mentions;
    std::map<std::pair<std::string, Digest>, bool> has;  // by file, and what its surroundings may add
  };
  std::shared_ptr<LightSearch> lightSearch_ = std::make_shared<LightSearch>();
  bool onlyLooks_ = false;              // for lights: what would wait without one is passed
  bool saysLights_ = false;             // a light was met, or an instance of an object that has one
  std::set<uint32_t> lightingObjects_;  // places in prototypes_ of those that have one

  std::set<std::string> keptNames_, unknownNames_;
  std::set<scene::NodePtr> lateReported_;
};

// Takes the positional arguments of a request one after the other; a scalar may stand in brackets and a row of
// scalars may be one array, as real files have both.
class Interpreter::Cursor {
 public:
  explicit Cursor(Request& r) : request(r) {}
  bool number(double& v) { return numbers(1, &v); }
  bool numbers(size_t count, double* out);
  bool string(std::string& v);  // a number is taken as its digits: handles
  bool nextIsString() const { return at < request.count && request.args[at].kind == Argument::Kind::Strings; }
  Argument* array(Argument::Kind kind);  // null when the next argument is not of this kind
  bool integers(std::vector<int>& v);
  bool floats(std::vector<float>& v);
  bool strings(std::vector<std::string>& v);
  Request& request;
  size_t at = 0;
};

}  // namespace kinora::rib
