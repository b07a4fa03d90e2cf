// A shader group as the renderer describes it: layers, the values given to their parameters, and connections.
// flatten() makes one program of it: one tree of code, in which each layer stands once, where its outputs are first
// needed. Layers that nothing needs vanish. Reference: osl-numerics, section 11 "Precedence", "Connections", "Lazy".
#pragma once
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "language/program/program.h"

namespace kinora::language {

struct Setting {
  std::string parameter;  // "name", or "name.field" of a struct
  Type type;
  Values values;
};

struct Layer {
  std::shared_ptr<const Shader> shader;
  std::string name;
  std::vector<Setting> settings;
};

struct Connection {
  std::string fromLayer, from, toLayer, to;  // parameters: "name", "name.field", "name[component]", "name[element]"
};

// A value that the renderer gives with each run: a parameter's instance value, or one that differs from point to
// point.
struct Input {
  int32_t layer = 0;
  std::string parameter;
  Type type;
  SymbolId symbol = kNone;  // in FlatProgram::code
  bool isVarying = false, hasDerivs = false;
  Values values;  // of the group that was flattened, in `type`; empty when isVarying
};

struct Output {
  std::string name;  // as it was asked for
  SymbolId symbol = kNone;
  Type type;
};

struct PerPoint {
  bool isVarying = false, hasDerivs = false;
  bool isConnected = false;  // what feeds it is not in the group: isconnected() says so
  // Not there for all points. Where code computes the default, an int input "name?" says for which; elsewhere the
  // values given are what holds without it.
  bool isPartial = false;
};

struct ShaderGroup {
  std::string name;
  std::vector<Layer> layers;  // the last one runs first and calls for the others
  std::vector<Connection> connections;
  std::vector<std::string> outputs;  // "layer.parameter", or "parameter" of the last layer
  std::vector<std::string> entries;  // layers to run, in order, in place of the last one and those with outputs
  std::vector<std::string> eager;    // layers that run before the last one although nothing needs them
  // Parameters whose value the renderer gives point by point: primvars of parameters that are not locked to their
  // geometry, instances that differ. Empty: none.
  std::function<PerPoint(const Layer&, const Symbol& parameter)> perPoint;
};

struct FlatProgram {
  Shader code;                       // symbols: Constant, Global, Param (an input), Local and Temp
  std::vector<std::string> layers;   // names; Instruction::layer
  std::vector<std::string> shaders;  // names, by layer
  std::vector<std::string> names;    // Instruction::name
  std::vector<uint32_t>
      mostTurns;  // by layer: of a loop, by the shader's metadata `kinora_max_iterations`; 0: not said
  std::string group;
  std::vector<Input> inputs;
  std::vector<Output> outputs;
  std::vector<std::string> warnings;
};

// False with `error`, one line for each thing that is wrong, when the group cannot run.
bool flatten(const ShaderGroup&, FlatProgram&, std::string& error);

// The structure that decides a program: shaders, connections, outputs, which parameters are given, and the values
// that are compiled in. Groups of equal keys share one executable; their float-like values are its inputs.
std::string structureKey(const ShaderGroup&);

// Of passes: the symbol of a constant, made when there is none like it.
class ConstantPool {
 public:
  explicit ConstantPool(Shader& shader);
  SymbolId find(const Type&, Values);
  SymbolId ofInt(int32_t);
  SymbolId ofFloat(float);
  SymbolId ofString(const std::string&);

 private:
  Shader& shader_;
  struct Map;
  std::shared_ptr<Map> map_;
};

}  // namespace kinora::language
