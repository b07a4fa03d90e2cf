// Closures of programs that look at them: print one, or ask whether there is one. They become numbers of entries in a
// table that a run keeps of what was made, weighed and added (vm/closures.h). In all other programs closures have no
// value, and nothing is computed of them.
#include <algorithm>

#include "language/optimise/optimise.h"
#include "language/optimise/walk.h"

namespace kinora::language {

namespace {

class ClosureValues {
 public:
  explicit ClosureValues(FlatProgram& flat) : flat_(flat), shader_(flat.code), pool_(flat.code) {}

  bool isNeeded() const {
    bool looks = false;
    forEachInstruction(shader_.main, [&](const Instruction& in) { looks |= looksAtClosures(in); });
    return looks;
  }

  void run() {
    // an output of a closure holds nothing, as ever
    for (Output& o : flat_.outputs)
      if (isClosure(o.symbol)) o.symbol = added(shader_.symbols[size_t(o.symbol)].type);
    kept_ = shader_.symbols.size();
    block(shader_.main);
    std::vector<Instruction> begin;
    for (size_t s = 0; s < kept_; ++s) {
      if (!isClosure(SymbolId(s)) || isOutput(SymbolId(s))) continue;
      const Type type{Base::Int, shader_.symbols[s].type.arrayLength, -1};
      shader_.symbols[s].type = type;
      if (shader_.symbols[s].kind == SymbolKind::Global) shader_.symbols[s].kind = SymbolKind::Local;  // Ci
      Instruction none;
      none.opcode = type.arrayLength ? Opcode::ArrayCopy : Opcode::Assign;
      Values zeros;
      zeros.ints.assign(size_t(std::max(1, type.arrayLength)), 0);
      none.arguments = {SymbolId(s), pool_.find(type, std::move(zeros))};
      begin.push_back(std::move(none));
    }
    shader_.main.code.insert(shader_.main.code.begin(), std::make_move_iterator(begin.begin()),
                             std::make_move_iterator(begin.end()));
  }

 private:
  bool isClosure(SymbolId s) const { return shader_.symbols[size_t(s)].type.base == Base::Closure; }
  bool isOutput(SymbolId s) const {
    return std::any_of(flat_.outputs.begin(), flat_.outputs.end(), [&](const Output& o) { return o.symbol == s; });
  }
  static bool printsText(Opcode op) {
    return op == Opcode::Printf || op == Opcode::Error || op == Opcode::Warning || op == Opcode::Fprintf ||
           op == Opcode::Format;
  }
  bool looksAtClosures(const Instruction& in) const {
    if (!printsText(in.opcode) && in.opcode != Opcode::Eq && in.opcode != Opcode::Neq) return false;
    return std::any_of(in.arguments.begin(), in.arguments.end(), [&](SymbolId s) { return isClosure(s); });
  }

  SymbolId added(const Type& type) {
    Symbol symbol;
    symbol.name = "$closure" + std::to_string(shader_.symbols.size());
    symbol.kind = SymbolKind::Temp;
    symbol.type = type;
    shader_.symbols.push_back(std::move(symbol));
    return SymbolId(shader_.symbols.size()) - 1;
  }

  void block(Block& code) {
    std::vector<Instruction> made;
    made.reserve(code.code.size());
    for (Instruction& in : code.code) {
      for (Block& inner : in.blocks) block(inner);
      instruction(in, made);
      made.push_back(std::move(in));
    }
    code.code = std::move(made);
  }

  void instruction(Instruction& in, std::vector<Instruction>& before) {
    if (in.arguments.empty()) return;
    if (printsText(in.opcode)) {
      for (SymbolId& s : in.arguments)
        if (isClosure(s)) s = textOf(s, in, before);
      return;
    }
    if (!isClosure(in.arguments[0])) return;
    if (in.opcode == Opcode::MakeClosure) {
      // which of the parameters are closures: their numbers look like ints
      uint32_t closures = 0;
      for (size_t k = 2; k < in.arguments.size() && k < 34; ++k)
        closures |= isClosure(in.arguments[k]) ? 1u << (k - 2) : 0u;
      in.opcode = Opcode::ClosureMake;
      in.arguments.insert(in.arguments.begin() + 2, pool_.ofInt(int32_t(closures)));
    } else if (in.opcode == Opcode::Add) {
      in.opcode = Opcode::ClosureAdd;
    } else if (in.opcode == Opcode::Mul) {
      in.opcode = Opcode::ClosureMul;
      if (!isClosure(in.arguments[1])) std::swap(in.arguments[1], in.arguments[2]);
    }
  }

  SymbolId textOf(SymbolId closure, const Instruction& in, std::vector<Instruction>& before) {
    Instruction text;
    text.opcode = Opcode::ClosureText;
    text.arguments = {added({Base::String, shader_.symbols[size_t(closure)].type.arrayLength, -1}), closure};
    text.pos = in.pos;
    text.layer = in.layer;
    const SymbolId made = text.arguments[0];
    before.push_back(std::move(text));
    return made;
  }

  FlatProgram& flat_;
  Shader& shader_;
  ConstantPool pool_;
  size_t kept_ = 0;
};

}  // namespace

void makeClosureValues(FlatProgram& flat) {
  ClosureValues values(flat);
  if (values.isNeeded()) values.run();
}

}  // namespace kinora::language
