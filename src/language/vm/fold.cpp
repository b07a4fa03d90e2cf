#include "language/optimise/fold.h"

#include <cstring>

#include "language/vm/executable.h"
#include "language/vm/strings.h"

namespace kinora::language {

struct Folder::Machine {
  RunState state;
  FlatProgram flat;
};

Folder::Folder(Shader& shader, ConstantPool& pool)
    : shader_(shader), pool_(pool), machine_(std::make_unique<Machine>()) {}
Folder::~Folder() = default;

SymbolId Folder::fold(const Instruction& in) {
  const uint32_t flags = factsOf(in.opcode).flags;
  if (flags & (kOpBlocks | kOpEffect | kOpGlobalState)) return kNone;
  switch (in.opcode) {
    case Opcode::IsConstant:
    case Opcode::Texture:
    case Opcode::Texture3d:
    case Opcode::Environment:
    case Opcode::GetTextureInfo:
    case Opcode::DictFind:
    case Opcode::DictNext:
    case Opcode::DictValue:
    case Opcode::Nop:
    case Opcode::End:
      return kNone;
    default:
      break;
  }
  if (in.arguments.empty() || accessOf(shader_, in, 0) != 'w') return kNone;
  for (uint32_t i = 1; i < in.arguments.size(); ++i) {
    if (accessOf(shader_, in, i) != 'r') return kNone;
    const Symbol& s = shader_.symbols[size_t(in.arguments[i])];
    if (s.kind != SymbolKind::Constant || s.type.base == Base::Closure || s.type.base == Base::Struct) return kNone;
  }
  // spaces are the renderer's
  const Opcode op = in.opcode;
  if (op == Opcode::MakeColor || op == Opcode::MakePoint || op == Opcode::MakeVector || op == Opcode::MakeNormal ||
      op == Opcode::MakeMatrix)
    if (in.arguments.size() > 1 && shader_.symbols[size_t(in.arguments[1])].type.base == Base::String &&
        op != Opcode::MakeColor)
      return kNone;
  const Type type = shader_.symbols[size_t(in.arguments[0])].type;
  if (componentsOf(type.base) == 0 || type.arrayLength != 0) return kNone;
  return evaluate(in, type);
}

SymbolId Folder::convert(SymbolId constant, const Type& type) {
  if (componentsOf(type.base) == 0 || type.arrayLength != 0 ||
      shader_.symbols[size_t(constant)].type.arrayLength != 0)
    return kNone;
  Instruction in;
  in.opcode = Opcode::Assign;
  in.arguments = {0, constant};
  return evaluate(in, type);
}

SymbolId Folder::evaluate(const Instruction& in, const Type& type) {
  FlatProgram& flat = machine_->flat;
  flat.code.symbols.clear();
  flat.code.main.code.clear();
  flat.outputs.clear();
  flat.layers.assign(1, "");
  flat.shaders.assign(1, "");
  Symbol result;
  result.kind = SymbolKind::Temp;
  result.type = type;
  flat.code.symbols.push_back(result);
  Instruction one;
  one.opcode = in.opcode;
  one.arguments.push_back(0);
  for (size_t i = 1; i < in.arguments.size(); ++i) {
    flat.code.symbols.push_back(shader_.symbols[size_t(in.arguments[i])]);
    one.arguments.push_back(SymbolId(i));
  }
  flat.code.main.code.push_back(std::move(one));
  flat.outputs.push_back({"", 0, type});
  MachineOptions options;
  options.width = 1;
  std::string error;
  const auto program = generate(flat, options, error);
  if (!program) return kNone;  // code generation will say what is wrong, with its place
  bool said = false;
  RendererServices services;
  services.self = &said;
  services.message = [](void* self, MessageKind, const char*, uint32_t, const char*) {
    *static_cast<bool*>(self) = true;
  };
  const uint32_t n = uint32_t(componentsOf(type.base));
  float cells[16][16] = {};
  float* pointers[16];
  for (uint32_t k = 0; k < 16; ++k) pointers[k] = cells[k];
  const OutputValues output{pointers};
  RunArguments run;
  run.points = 1;
  run.outputs = &output;
  run.services = &services;
  RunState& state = machine_->state;
  program->run(state, run);
  if (said) return kNone;  // it has something to tell when it runs
  Values values;
  for (uint32_t k = 0; k < n; ++k) {
    if (type.base == Base::Float || isTriple(type.base) || type.base == Base::Matrix) {
      values.floats.push_back(cells[k][0]);
    } else {
      int32_t bits;
      std::memcpy(&bits, &cells[k][0], 4);
      if (type.base == Base::Int)
        values.ints.push_back(bits);
      else
        values.strings.push_back(stringOf(bits));
    }
  }
  return pool_.find(type, std::move(values));
}

}  // namespace kinora::language
