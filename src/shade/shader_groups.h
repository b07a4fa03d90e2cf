// Shaders of a network run as groups: nodes of the shading language that feed each other become one program of the
// group machine, whatever C++ patterns stand around them. Built by MaterialSet::finish(), run by contexts.
#pragma once
#include <array>
#include <memory>
#include <string>
#include <vector>

#include "base/diagnostics.h"
#include "language/vm/executable.h"

namespace kinora {
struct Context;
namespace shade {

struct Program;
struct ContextHost;

// One group of a program.
struct ShaderUse {
  std::shared_ptr<const language::Executable> code;
  std::vector<float> inputs;  // uniform ones
  struct Varying {
    uint32_t node = 0, param = 0;
    bool isPrimvar = false;  // of the parameter's name where an object has it, else the parameter's value
    language::Base base = language::Base::Float;
    bool isConnected = false;        // to what is not in the group
    bool asksWhether = false;        // not the primvar, but whether the object has it: else code computes the value
    uint32_t elements = 0;           // of an array; 0: none
    std::vector<float> otherwise{};  // of an array: what stands where there is no primvar, as the machine has it
  };
  std::vector<Varying> varying;  // in the order of the machine's varying inputs
  struct Out {
    uint32_t node = 0, output = 0;
    language::Base base = language::Base::Float;
  };
  std::vector<Out> outputs;  // in the order of the machine's outputs
  std::vector<uint32_t> nodes;
  uint32_t number = 0;     // among those of all programs, for counting
  std::string name;        // of its shaders
  uint64_t bytes() const;  // without its code, which others may share
  // What the code reads, asked once.
  bool wantsDerivs = false, hasPrimvars = false;
  std::array<bool, language::GlobalValues::Count> wants{};
};

// What a thread counts of one ShaderUse.
struct ShaderCounts {
  language::RunCounts machine;
  uint64_t nanoseconds = 0;  // with what is made ready for the machine
};

// Groups the program's shader nodes and compiles them. What cannot run is told, and its nodes compute nothing.
void makeShaderUses(Program& program, language::ExecutableCache& cache, uint32_t width, Diagnostics& diagnostics);

// All outputs of the group's nodes, for the points of the context.
void runShaders(const Context* c, ContextHost& host, const ShaderUse& use);

}  // namespace shade
}  // namespace kinora
