#include "language/optimise/instrument.h"

#include <cstdint>
#include <limits>
#include <unordered_set>
#include <utility>

#include "language/optimise/group.h"

namespace kinora::language {

namespace {

constexpr int32_t kMostMarked = 4096;  // elements of an array that is marked as never set

class Instrumenter {
 public:
  Instrumenter(Shader& shader, bool nan, bool uninitialised)
      : shader_(shader), pool_(shader), nan_(nan), uninitialised_(uninitialised) {}

  void run() {
    const size_t symbols = shader_.symbols.size();
    for (const Initialiser& i : shader_.initialisers) findUnset(i.code);
    findUnset(shader_.main);
    for (Initialiser& i : shader_.initialisers) walk(i.code);
    walk(shader_.main);
    if (!uninitialised_) return;
    std::vector<Instruction> marks;
    for (size_t i = 0; i < symbols; ++i) {
      const Type type = shader_.symbols[i].type;
      const size_t n = size_t(componentsOf(type.base)) * size_t(std::max(1, type.arrayLength));
      if (isUnset(SymbolId(i))) shader_.symbols[i].values.strings.assign(n, kUninitialisedText);
      if (!isMarked(SymbolId(i)) || type.base == Base::String) continue;
      Values values;
      if (type.base == Base::Int)
        values.ints.assign(n, std::numeric_limits<int32_t>::min());
      else
        values.floats.assign(n, std::numeric_limits<float>::quiet_NaN());
      Instruction mark;
      mark.opcode = type.arrayLength ? Opcode::ArrayCopy : Opcode::Assign;
      mark.arguments = {SymbolId(i), pool_.find(type, std::move(values))};
      marks.push_back(std::move(mark));
    }
    auto& code = shader_.main.code;
    code.insert(code.begin(), std::make_move_iterator(marks.begin()), std::make_move_iterator(marks.end()));
  }

 private:
  bool isUnset(SymbolId id) const {
    const Symbol& s = shader_.symbols[size_t(id)];
    return s.kind == SymbolKind::Constant && s.name.starts_with(kUnsetName);
  }
  // Strings begin as nothing where they are declared without a value, which is an instruction.
  void findUnset(const Block& block) {
    for (const Instruction& in : block.code) {
      if ((in.opcode == Opcode::Assign || in.opcode == Opcode::ArrayCopy) && isUnset(in.arguments[1]))
        beginsUnset_.insert(in.arguments[0]);
      for (const Block& inner : in.blocks) findUnset(inner);
    }
  }
  bool isMarked(SymbolId id) const {
    const Symbol& s = shader_.symbols[size_t(id)];
    if (s.type.base == Base::String && !beginsUnset_.contains(id)) return false;
    return s.kind == SymbolKind::Local && componentsOf(s.type.base) > 0 && s.type.arrayLength >= 0 &&
           s.type.arrayLength <= kMostMarked;
  }
  // As the source spells it: a local may be written ___SCOPE_name.
  static std::string plainName(std::string name) {
    if (!name.starts_with("___")) return name;
    size_t at = 3;
    while (at < name.size() && name[at] >= '0' && name[at] <= '9') ++at;
    return at > 3 && at + 1 < name.size() && name[at] == '_' ? name.substr(at + 1) : name;
  }
  // Which part of argument `i` an instruction reads or writes: arguments of indices.
  static std::vector<SymbolId> partOf(const Instruction& in, uint32_t i) {
    switch (in.opcode) {
      case Opcode::ArrayRef:
      case Opcode::ComponentRef:
        return i == 1 ? std::vector<SymbolId>{in.arguments[2]} : std::vector<SymbolId>{};
      case Opcode::MatrixRef:
        return i == 1 ? std::vector<SymbolId>{in.arguments[2], in.arguments[3]} : std::vector<SymbolId>{};
      case Opcode::ArrayAssign:
      case Opcode::ComponentAssign:
        return i == 0 ? std::vector<SymbolId>{in.arguments[1]} : std::vector<SymbolId>{};
      case Opcode::MatrixAssign:
        return i == 0 ? std::vector<SymbolId>{in.arguments[1], in.arguments[2]} : std::vector<SymbolId>{};
      default:
        return {};
    }
  }

  void walk(Block& block) {
    std::vector<Instruction> made;
    for (Instruction& in : block.code) {
      const uint32_t number = number_++;
      const std::string name(factsOf(in.opcode).name);
      const bool isPlain = !isLoop(in.opcode) && in.opcode != Opcode::Call && in.opcode != Opcode::IsConnected &&
                           in.opcode != Opcode::IsConstant && in.opcode != Opcode::ArrayLength;
      const auto check = [&](Opcode op, std::string first, std::string second, uint32_t i) {
        Instruction c;
        c.opcode = op;
        c.pos = in.pos;
        c.arguments = {pool_.ofString(first), pool_.ofString(second), in.arguments[i]};
        for (const SymbolId index : partOf(in, i)) c.arguments.push_back(index);
        made.push_back(std::move(c));
      };
      for (uint32_t i = 0; uninitialised_ && isPlain && i < in.arguments.size(); ++i) {
        if (accessOf(shader_, in, i) != 'r' || !isMarked(in.arguments[i])) continue;
        const Symbol& s = shader_.symbols[size_t(in.arguments[i])];
        check(Opcode::DebugUninit, nameOf(s.type) + " " + plainName(s.name),
              "op " + std::to_string(number) + " '" + name + "', arg " + std::to_string(i), i);
      }
      for (Block& inner : in.blocks) walk(inner);
      std::vector<std::pair<std::string, uint32_t>> written;
      for (uint32_t i = 0; nan_ && isPlain && in.blocks.empty() && i < in.arguments.size(); ++i) {
        const Symbol& s = shader_.symbols[size_t(in.arguments[i])];
        const bool isFloat = s.type.base == Base::Float || isTriple(s.type.base) || s.type.base == Base::Matrix;
        if (accessOf(shader_, in, i) != 'r' && isFloat && s.type.arrayLength >= 0)
          written.push_back({plainName(s.name), i});
      }
      made.push_back(in);
      for (const auto& [symbol, i] : written) check(Opcode::DebugNan, symbol, name, i);
    }
    block.code = std::move(made);
  }

  Shader& shader_;
  ConstantPool pool_;
  std::unordered_set<SymbolId> beginsUnset_;
  bool nan_, uninitialised_;
  uint32_t number_ = 0;
};

}  // namespace

Shader instrumented(Shader shader, bool tellsNan, bool tellsUninitialised) {
  if (tellsNan || tellsUninitialised) Instrumenter(shader, tellsNan, tellsUninitialised).run();
  return shader;
}

}  // namespace kinora::language
