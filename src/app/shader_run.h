// The parts of `kinora shader run`: what the command line asks for, the shader group it describes, and the world its
// points live in. CLI.md, "Shaders", is the contract; each part has a file of its own.
#pragma once
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "app/shader_commands.h"
#include "language/vm/executable.h"

namespace kinora::app {

// ---- shader_run_options.cpp ----

// What sets the group up, in the order of the command line.
struct GroupStep {
  enum Kind : uint8_t { Param, Shader, LayerName, Connect, Group, Expression, Reparam, UserData } kind = Param;
  std::string modifiers;           // of --param:type=float[2]:lockgeom=0 what follows the first colon
  std::vector<std::string> words;  // the option's values
};

struct ShadeGrid {
  uint32_t width = 1, height = 1;
  bool isCentered = false;  // u, v at the middle of pixels
  bool varyP = false, varyU = false, varyV = false;
  float scale[2] = {1, 1}, offset[2] = {0, 0};
  uint64_t points() const { return uint64_t(width) * height; }
};

struct ShadeOutput {
  std::string variable, file;  // file "null": computed, not written
};

struct RunJob {
  ShadeGrid grid;
  std::vector<GroupStep> steps;
  std::vector<ShadeOutput> outputs;
  std::vector<std::string> entries, path;
  std::map<std::string, std::string> options;  // --options name=value,...
  std::string groupName, entryOutput, rayType = "camera", colorSpace, storedType;
  language::CompileOptions compile;
  int iterations = 1, threads = 0, width = 0, optimisation = 2;
  bool isQuiet = false, isVerbose = false, hasStats = false, printsOutputs = false;
  bool debugNan = false, debugUninit = false, userDataIsConnected = false;
  int option(const char* name, int otherwise) const;
};

// An exit code when the program is done: help was printed, or the command line is wrong.
std::optional<int> parseRun(const Arguments& arguments, RunJob& job);

// ---- shader_run_group.cpp ----

// A value of the command line, or of a group's text.
struct NamedValue {
  std::string name;
  language::Type type;
  language::Values values;
};

struct RunGroup {
  language::ShaderGroup group;
  std::set<std::string> unlocked, locked;  // "layer.parameter" with a hint on the command line
  std::vector<NamedValue> userData;
  std::vector<language::Setting> reparams;  // of layer
  std::vector<std::string> reparamLayers;   // one for each
  std::string connections;                  // what was connected, as text to print
};

// False: said why on standard error.
bool makeGroup(const RunJob& job, RunGroup& out);
// The group as text from which --group makes the same.
std::string serialised(const RunGroup& group);

// Finds what a name with its hints and words means: false with `error`.
bool parseValue(const std::string& typeName, const std::string& text, language::Type& type, language::Values& values,
                std::string& error);

// ---- shader_run_world.cpp ----

// The points of a grid in slices, and what shaders ask about them.
class ShadeWorld {
 public:
  ShadeWorld(const RunJob& job, std::vector<NamedValue> userData);
  ~ShadeWorld();
  ShadeWorld(const ShadeWorld&) = delete;
  // Whether a primvar of that name and type is there for some points at least.
  bool hasPrimvar(const std::string& name, const language::Type& type) const;
  static bool isPartial(const std::string& name) { return name == "red" || name == "green" || name == "blue"; }

  // One worker's slice of points.
  class Slice {
   public:
    Slice(const ShadeWorld& world, language::Dictionary& dictionary, uint32_t most);
    ~Slice();
    void fill(uint64_t first, uint32_t count);
    const language::GlobalValues& globals() const;
    const language::RendererServices& services() const;
    // Primvars for Executable::inputs() that vary; `otherwise` are the values of the group.
    const language::VaryingInput* inputs(const language::Executable& code, const language::ShaderGroup& group);
    struct Impl;

   private:
    std::unique_ptr<Impl> impl_;
  };

  struct Impl;
  const Impl& parts() const { return *impl_; }

 private:
  std::unique_ptr<Impl> impl_;
};

}  // namespace kinora::app
