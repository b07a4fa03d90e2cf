// What every plug-in exports: one C descriptor with its parameters and, for each width it was built for, a table of
// functions over padded spans. Only plain data crosses this boundary: no templates, no standard-library types, no
// exceptions. Authors write against the thin C++ layers in bxdf.h, pattern.h, light.h, integrator.h, ...; the host
// reads nothing but what is declared here and there.
#pragma once
#include <cstddef>
#include <cstdint>
#include <exception>

namespace kinora {

// Raised whenever a struct or a function signature in include/kinora/ changes. Another version is refused.
inline constexpr uint32_t kAbiVersion = 19;

// Arrays over points, rays or lanes are padded to this many elements, and their padding holds valid numbers.
inline constexpr uint32_t kPad = 16;
inline constexpr uint32_t padded(uint32_t n) { return (n + kPad - 1) & ~(kPad - 1); }

enum class Kind : uint32_t {
  Bxdf,
  Pattern,
  Light,
  LightFilter,
  Integrator,
  Projection,
  Displacement,
  Volume,
  PixelFilter,
  SampleFilter,
  DisplayFilter,
  Display
};
enum class Type : uint32_t { Float, Int, String, Color, Point, Vector, Normal, Matrix, Struct };

enum ParamFlags : uint32_t {
  kParamOutput = 1,  // computed by the node (patterns)
  kParamArray = 2,   // type[]; any length
  kParamFile = 4,    // a string that names a texture: each point gets the handle (an int), see Context::param
  kParamNotConnectable = 8,
  kParamFixed = 16,      // part of the shading program: materials that differ in it never share a shading group
  kParamGradients = 32,  // a manifold whose gradients are read: what it is connected to computes them
  kParamTraceSet = 64    // a string that names the groups of objects which a pattern's rays see, see ProbeRays
};

// One parameter, declared once: read by the RIB reader, `kinora plugins NAME`, the manual and every test loop.
struct Param {
  const char* name = "";
  Type type = Type::Float;
  uint32_t flags = 0;
  float value[3] = {0, 0, 0};   // default of numeric types (ints as floats)
  const char* text = "";        // default of strings
  const float* list = nullptr;  // default of arrays: listCount numbers
  uint32_t listCount = 0;
  float low = 0, high = 1;   // range that makes sense, ends included: tests walk it, interfaces show it
  const char* choices = "";  // "0 Beckmann, 1 GGX", "down|right|up|left"; "" when free
  const char* doc = "";      // meaning, unit, space

  constexpr Param range(float lo, float hi) const {
    Param p = *this;
    p.low = lo;
    p.high = hi;
    return p;
  }
  constexpr Param help(const char* text_) const {
    Param p = *this;
    p.doc = text_;
    return p;
  }
  constexpr Param options(const char* list_) const {
    Param p = *this;
    p.choices = list_;
    return p;
  }
  constexpr Param fixed() const {
    Param p = *this;
    p.flags |= kParamFixed | kParamNotConnectable;
    return p;
  }
  constexpr Param gradients() const {
    Param p = *this;
    p.flags |= kParamGradients;
    return p;
  }
  constexpr Param traceSet() const {
    Param p = *this;
    p.flags |= kParamTraceSet;
    return p;
  }
  constexpr Param file() const {
    Param p = *this;
    p.flags |= kParamFile | kParamNotConnectable;
    return p;
  }
};

namespace param {
constexpr Param make(Type t, const char* name, float a, float b, float c) {
  Param p;
  p.name = name;
  p.type = t;
  p.value[0] = a;
  p.value[1] = b;
  p.value[2] = c;
  return p;
}
constexpr Param number(const char* name, float v) { return make(Type::Float, name, v, v, v); }
// Integers steer structure (modes, switches), so they are part of the program unless declared otherwise.
constexpr Param integer(const char* name, int v) { return make(Type::Int, name, float(v), 0, 0).fixed(); }
// What is so or not: 1 or 0, the range of all parameters that say no other.
constexpr Param flag(const char* name, bool v) { return integer(name, v); }
constexpr Param onOff(const char* name, bool v) { return flag(name, v).options("0 off, 1 on"); }
constexpr Param color(const char* name, float v) { return make(Type::Color, name, v, v, v); }
constexpr Param color(const char* name, float r, float g, float b) { return make(Type::Color, name, r, g, b); }
constexpr Param point(const char* name, float x, float y, float z) {
  return make(Type::Point, name, x, y, z).range(-10, 10);
}
constexpr Param vector(const char* name, float x, float y, float z) {
  return make(Type::Vector, name, x, y, z).range(-1, 1);
}
// 0 0 0 means "not connected: use the shading normal".
constexpr Param normal(const char* name) { return make(Type::Normal, name, 0, 0, 0).range(-1, 1); }
constexpr Param string(const char* name, const char* v) {
  Param p;
  p.name = name;
  p.type = Type::String;
  p.text = v;
  p.flags = kParamFixed | kParamNotConnectable;
  return p;
}
constexpr Param structure(const char* name) {
  Param p;
  p.name = name;
  p.type = Type::Struct;
  return p;
}
constexpr Param array(Type t, const char* name, const float* list, uint32_t count) {
  Param p;
  p.name = name;
  p.type = t;
  p.flags = kParamArray | kParamFixed | kParamNotConnectable;
  p.list = list;
  p.listCount = count;
  return p;
}
constexpr Param output(Type t, const char* name) {
  Param p;
  p.name = name;
  p.type = t;
  p.flags = kParamOutput;
  return p;
}
}  // namespace param

// A resolved parameter of one node: the default where the scene gives none. Valid during create() only.
struct ParamValue {
  const float* floats = nullptr;  // numeric types, ints converted
  const char* const* strings = nullptr;
  uint32_t count = 0;      // floats or strings
  uint32_t given = 0;      // 1: the scene sets it
  uint32_t connected = 0;  // 1: fed by a pattern; the value is not known yet

  // False where it is known to be 0: a lobe of that weight is off.
  bool mayBeOn() const {
    for (uint32_t i = 0; i < count && !connected; ++i)
      if (floats[i] != 0.f) return true;
    return connected;
  }
};

// An image for set-up code (light maps). Row-major, top row first, `channels` floats a pixel, scene-linear.
struct HostImage {
  const float* pixels;
  uint32_t width, height, channels;
};

// Services of the renderer for set-up code. Thread-safe. Strings are UTF-8 and live as long as the call.
struct Host {
  void* self;
  void (*warn)(void* self, const char* code, const char* what, const char* done);
  // Loads an image along the texture search path; null when missing (a warning has been given). linearize: 1 decodes
  // sRGB, 0 takes values as they are, -1 decides by file type. The image lives as long as the world.
  const HostImage* (*image)(void* self, const char* file, int linearize);
};

// Where a light, a projection or an instance of a plug-in stands. Matrices are row-vector (p' = p M), row-major.
struct Placement {
  double localToRender[16];  // render space: world moved by a constant, so that the camera is near the origin
  double worldOrigin[3];     // render = world - worldOrigin
  int isStatic;              // 0: localToRender is the one at the middle of the shutter
};

// What create() learns. `extra` points to a struct of the kind: LightInfo ..., ProjectionInfo, DisplayInfo; else
// null.
struct CreateInfo {
  const Host* host;
  const char* handle;        // the node's name, for messages
  const ParamValue* values;  // one for each declared parameter, in order
  uint32_t valueCount;
  const Placement* placement;
  const void* extra;

  float number(uint32_t i) const { return values[i].count ? values[i].floats[0] : 0.f; }
  int integer(uint32_t i) const { return int(number(i)); }
  const char* string(uint32_t i) const { return values[i].count && values[i].strings ? values[i].strings[0] : ""; }
};

// Filled by a create() that fails; the host shows it and uses a fallback.
struct ErrorText {
  char text[512];
};

struct WidthTable {
  uint32_t width;
  const void* functions;
};  // BxdfFunctions, LightFunctions, ... of the kind

struct Descriptor {
  uint32_t abiVersion;  // first, and never moved
  uint32_t descriptorBytes;
  Kind kind;
  uint32_t flags;
  const char* name;
  const char* doc;
  const Param* params;
  uint32_t paramCount;
  const WidthTable* tables;
  uint32_t tableCount;
  const void* traits;  // BxdfTraits ... of the kind; may be null
  // Data of one node (light, integrator, projection, ...), made once before rendering; null: the node has none.
  void* (*create)(const CreateInfo*, ErrorText*);
  void (*destroy)(void*);
};

// Declarations of a plug-in: an array, or what has data() and size().
template <class T>
struct ListOf {
  const T* data = nullptr;
  uint32_t count = 0;
  constexpr ListOf() = default;
  template <size_t N>
  constexpr ListOf(const T (&list)[N]) : data(list), count(N) {}
  template <class L>
  requires requires(const L& l) { l.data()[l.size()].name; }
  constexpr ListOf(const L& list) : data(list.data()), count(uint32_t(list.size())) {}
};

// The exported symbol of a shared library: descriptor i, or null past the last.
using DescriptorFunction = const Descriptor* (*)(uint32_t index);
inline constexpr const char* kDescriptorSymbol = "kinoraPlugins";

// Runs a plug-in's code so that no exception crosses the boundary: 1, or 0 where one was thrown, which becomes an
// ErrorText.
template <class F>
int guardedCall(ErrorText* error, F&& run) noexcept {
  const auto say = [&](const char* what) {
    size_t i = 0;
    for (; what[i] && i + 1 < sizeof error->text; ++i) error->text[i] = what[i];
    error->text[i] = 0;
    return 0;
  };
  try {
    run();
    return 1;
  } catch (const char* what) {
    return say(what);
  } catch (const std::exception& e) {
    return say(e.what());
  } catch (...) {
    return say("an exception without a text");
  }
}
// The same of what makes something: null where it throws.
template <class F>
void* guardedCreate(ErrorText* error, F&& make) noexcept {
  void* made = nullptr;
  return guardedCall(error, [&] { made = make(); }) ? made : nullptr;
}

// Makes and deletes the data of a node: `Data`, constructed from a CreateInfo; the constructor may throw a text.
struct SetUp {
  void* (*create)(const CreateInfo*, ErrorText*) = nullptr;
  void (*destroy)(void*) = nullptr;
};
template <class Data>
inline constexpr SetUp setUp{
    [](const CreateInfo* info, ErrorText* error) { return guardedCreate(error, [&] { return new Data(*info); }); },
    [](void* data) { delete static_cast<Data*>(data); }};

// The same by a function that makes the data, std::unique_ptr<Data> make(const CreateInfo&); it may throw a text.
template <auto make>
inline constexpr SetUp setUpBy{[](const CreateInfo* info, ErrorText* error) -> void* {
                                 return guardedCreate(error, [&]() -> void* { return make(*info).release(); });
                               },
                               [](void* data) {
                                 using Pointer = decltype(make(*static_cast<const CreateInfo*>(nullptr)).release());
                                 delete static_cast<Pointer>(data);
                               }};

// Traits of kinds that have none.
struct NoTraits {};

// The descriptor of a plug-in by what its kind asks for (BxdfPlugin, PatternPlugin, ...). Tables and traits live as
// long as the program.
template <class Plugin, size_t N, class Traits>
constexpr Descriptor describe(const char* name, const Plugin& p, const WidthTable (&tables)[N],
                              const Traits& traits) {
  Descriptor d{kAbiVersion, sizeof(Descriptor), Plugin::kKind, 0,       name,   p.help, p.params.data, p.params.count,
               tables,      uint32_t(N),        &traits,       nullptr, nullptr};
  if constexpr (requires { p.flags; }) d.flags = p.flags;
  if constexpr (__is_same(Traits, NoTraits)) d.traits = nullptr;
  if constexpr (requires { p.setUp; }) {
    d.create = p.setUp.create;
    d.destroy = p.setUp.destroy;
  }
  return d;
}

}  // namespace kinora

#if defined(_WIN32)
#error "Kinora runs on Linux"
#endif
#define KINORA_EXPORT __attribute__((visibility("default")))

// Ends a plug-in's source file, in namespace kinora, after all targets: KINORA_REGISTER(PxrDiffuse, descriptor).
// Stock plug-ins are linked in and found by a generated table; the others export kDescriptorSymbol.
#if defined(KINORA_STOCK_PLUGIN)
#define KINORA_REGISTER(Name, descriptorObject) \
  const ::kinora::Descriptor* kinoraStock_##Name() { return &descriptorObject; }
#else
#define KINORA_REGISTER(Name, descriptorObject)                                        \
  extern "C" KINORA_EXPORT const ::kinora::Descriptor* kinoraPlugins(uint32_t index) { \
    return index == 0 ? &descriptorObject : nullptr;                                   \
  }
#endif

// A plug-in of a kind without widths: `functions` (of the kind's type) and the members of its kind's description.
#define KINORA_SCALAR_PLUGIN(Name, functions, Plugin, ...)                       \
  namespace kinora {                                                             \
  namespace {                                                                    \
  constexpr Plugin kPlugin{__VA_ARGS__};                                         \
  constexpr auto kTraits = kPlugin.traits();                                     \
  constexpr Plugin::Functions kFunctions = functions;                            \
  constexpr WidthTable kTables[] = {{1, &kFunctions}};                           \
  constexpr Descriptor kDescriptor = describe(#Name, kPlugin, kTables, kTraits); \
  }                                                                              \
  KINORA_REGISTER(Name, kDescriptor)                                             \
  }
