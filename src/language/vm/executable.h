// A program of the group machine: instructions over cells, made once from a shader group's structure, run by any
// number of threads at once, each with a RunState of its own. compileGroup() is the door for everybody outside.
#pragma once
#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "language/optimise/group.h"
#include "language/vm/closures.h"
#include "language/vm/kernel.h"
#include "language/vm/services.h"

namespace kinora::language {

struct MachineOptions {
  uint32_t width = 0;                  // 1, 4, 8, 16; 0: the widest of this CPU
  uint32_t iterationLimit = 1u << 20;  // of one loop in one block of points, unless its shader says another
  uint32_t blockPoints = 0;            // 0: by the working set
  bool optimise = true;
  bool rangeCheck = true;  // tell of indices out of range (they are clamped in any case)
  // Kernels of width 16 for CPUs without AVX-512: tests have some. Null, or null for a family: the library's own.
  const KernelFunction* (*kernels16)(Family) = nullptr;
};

// The point's variables, arrays for each component, padded to a multiple of 16 points; null: zeros.
struct GlobalValues {
  struct Values {
    const float* v[3] = {};
    const float* dx[3] = {};
    const float* dy[3] = {};
  };
  enum Name : uint8_t { P, I, N, Ng, dPdu, dPdv, Ps, dPdtime, u, v, time, dtime, Count };
  std::array<Values, Count> of;
  static int32_t named(std::string_view);  // -1: none
};

// One parameter that differs from point to point (Executable::inputs() with isVarying), padded like globals.
struct VaryingInput {
  const float* const* v = nullptr;  // by component; null: zeros
  const float* const* dx = nullptr;
  const float* const* dy = nullptr;
};

struct OutputValues {
  float* const* v = nullptr;  // by component, padded to a multiple of 16 points; null: not wanted
};

// What runs cost, counted in one run of kEvery: the others pay nothing for it.
struct RunCounts {
  static constexpr uint64_t kEvery = 16;
  uint64_t runs = 0, points = 0;
  uint64_t counted = 0;                    // runs that the rest is of
  uint64_t instructions = 0, uniform = 0;  // over points, and once for all of them
  uint64_t lanesRun = 0, lanesUsed = 0;    // that kernels worked on, that held a point which took part
  void add(const RunCounts&);
};

struct RunArguments {
  uint32_t points = 0;
  const GlobalValues* globals = nullptr;
  const float* inputs = nullptr;                // Executable::inputsOf(group)
  const VaryingInput* varyingInputs = nullptr;  // in the order of inputs() that vary
  const OutputValues* outputs = nullptr;        // in the order of outputs()
  const RendererServices* services = nullptr;
  RunCounts* counts = nullptr;   // null: not counted
  bool tellsEveryPoint = false;  // what goes wrong at one place is told for each point, not for the first alone
  // Takes messages in place of services->message, with the point that each comes from.
  void (*listener)(void* listening, uint32_t point, MessageKind, const std::string& text,
                   const std::string& file) = nullptr;
  void* listening = nullptr;
};

enum class Step : uint8_t { Run, RunOnce, Jump, JumpUnless, Chunks, AllChunks, Back, End };
// Chunks: those of a cell take part, and their points are in a mask (for RunCounts). Back: to a loop's first
// instruction, unless it has turned too often

struct MachineInstruction {
  KernelFunction kernel = nullptr;
  uint32_t words = 0;   // index into words_
  uint32_t target = 0;  // of jumps
  Step step = Step::Run;
};

// Where a message or a call belongs.
struct Site {
  std::string position;  // "file:line", or ""
  int32_t layer = 0;
  std::string name;  // of the array indexed, of the operation refused ...
};

class RunState;
class Executable;
// The machine's code for a flattened program as it stands; null with `error` (a line for each thing that is wrong).
std::shared_ptr<const Executable> generate(const FlatProgram&, const MachineOptions&, std::string& error);

class Executable {
 public:
  const std::vector<Input>& inputs() const { return inputs_; }
  const std::vector<Output>& outputs() const { return outputs_; }
  bool isVarying(size_t output) const { return boundOutputs_[output].varies; }
  const std::vector<std::string>& warnings() const { return warnings_; }
  const std::string& group() const { return group_; }
  uint32_t width() const { return width_; }
  uint32_t blockPoints() const { return blockPoints_; }
  // Of slots, in points: not a power of two, or stores and loads of other slots would fall on the same 4 KiB offsets.
  uint32_t stride() const { return blockPoints_ + 16; }
  size_t instructionCount() const { return code_.size(); }
  uint32_t slotCount() const { return slots_; }
  // Whether derivatives of any global or input are read.
  bool usesDerivs() const {
    for (const External& x : externals_)
      if (x.part != 0) return true;
    return false;
  }
  bool usesGlobal(GlobalValues::Name name) const {
    for (const External& x : externals_)
      if (x.kind == External::Global && x.index == name) return true;
    return false;
  }
  // The uniform values of a group of this structure, for RunArguments::inputs. Empty when there are none.
  std::vector<float> inputsOf(const ShaderGroup&) const;
  void run(RunState&, const RunArguments&) const;
  uint64_t bytes() const;       // held for it
  std::string listing() const;  // for people

 private:
  template <bool kCounts>
  void runBlock(Frame, const Frame& once, RunCounts*) const;
  friend class CodeGenerator;
  friend std::shared_ptr<const Executable> generate(const FlatProgram&, const MachineOptions&, std::string&);
  friend class RunState;
  struct External {
    enum Kind : uint8_t { Global, Input, Output } kind = Global;
    uint32_t index = 0, component = 0;
    uint8_t part = 0;       // 0 value, 1 dx, 2 dy
    uint32_t cell = 0;      // that points to it
    uint32_t fallback = 0;  // slot for an output that nobody wants
  };
  struct BoundOutput {
    uint32_t cell = 0, components = 0;
    bool varies = false, isDirect = false;  // direct: its cells are the caller's arrays
    Base base = Base::Float;
  };
  std::string group_;
  std::vector<std::string> layers_, shaders_;
  std::vector<Input> inputs_;
  std::vector<Output> outputs_;
  std::vector<BoundOutput> boundOutputs_;
  std::vector<std::string> warnings_;
  std::vector<MachineInstruction> code_;
  std::vector<uint32_t> words_;
  std::vector<const char*> names_;  // of instructions, for listing()
  std::vector<Site> sites_;
  std::vector<External> externals_;
  std::vector<uint32_t> uniformImage_;  // what uniform cells hold when a run begins
  std::vector<uint32_t> inputCells_;    // first uniform cell of each uniform input
  uint32_t uniforms_ = 0, slots_ = 0, cells_ = 0, width_ = 0, blockPoints_ = 0, iterationLimit_ = 0;
  uint64_t mostTurns_ = 0;  // of all loops in one block: loops inside each other must end too
  bool rangeCheck_ = true;
  uint64_t number_ = 0;  // no other executable of this process has it: addresses come again
  friend struct SiteAccess;
};

// A thread's memory for running programs: made once, grows to the largest program it has seen, no allocation after
// that but for messages.
class RunState {
 public:
  // What one point had to say.
  struct Spoken {
    uint32_t point = 0;
    MessageKind kind = MessageKind::Printf;
    std::string text, file;
  };
  const RendererServices* services = nullptr;
  const Executable* program = nullptr;
  std::vector<Spoken> spoken;
  std::vector<uint8_t> toldOnce;  // by site
  ClosureTable closures;
  bool isSpent = false;  // loops together have turned as often as they may: a block was left as it was
  bool tellsEveryPoint = false;
  float* scratch(uint32_t k) { return scratch_ + size_t(k) * stride_; }  // kScratch arrays of a block's points
  static constexpr uint32_t kScratch = 24;

  void say(uint32_t point, MessageKind kind, std::string text, std::string file = {}) {
    spoken.push_back({point, kind, std::move(text), std::move(file)});
  }

 private:
  friend class Executable;
  void attach(const Executable&);
  std::vector<float> memory_;
  std::vector<float*> cells_;
  uint64_t attached_ = 0;  // its number
  float* varying_ = nullptr;
  float* scratch_ = nullptr;
  uint32_t stride_ = 0;
};

struct SiteAccess {
  static const Site& site(const Executable& e, uint32_t i) { return e.sites_[i]; }
  static const std::string& layer(const Executable& e, int32_t i) { return e.layers_[size_t(i)]; }
  static const std::string& shader(const Executable& e, int32_t i) { return e.shaders_[size_t(i)]; }
  static bool rangeCheck(const Executable& e) { return e.rangeCheck_; }
  static uint64_t mostTurns(const Executable& e) { return e.mostTurns_; }
};

// Null with `error` (one line for each thing that is wrong) when the group cannot run.
std::shared_ptr<const Executable> compileGroup(const ShaderGroup&, const MachineOptions&, std::string& error);

// Executables by structure, so that instances which differ in parameters share one. Thread-safe.
class ExecutableCache {
 public:
  std::shared_ptr<const Executable> get(const ShaderGroup&, const MachineOptions&, std::string& error);
  // Drops what was made of a shader that nobody will ask for again; programs in use live on.
  void forget(const Shader&);
  size_t size() const;

 private:
  struct Entries;
  std::shared_ptr<Entries> entries_;

 public:
  ExecutableCache();
};

}  // namespace kinora::language
