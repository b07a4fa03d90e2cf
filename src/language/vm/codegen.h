// Makes the machine's instructions from a flattened program: chooses kernels by the operands' kinds, places masks and
// blends where points diverge, and gives values cells by their life times. Used by generate() alone.
#pragma once
#include <string>
#include <vector>

#include "language/optimise/analysis.h"
#include "language/vm/executable.h"

namespace kinora::language {

// The kernel that stands `by` places behind another in its family's list.
template <class K>
K variant(K base, int by) {
  return K(uint16_t(base) + uint16_t(by));
}

class CodeGenerator {
 public:
  CodeGenerator(const FlatProgram& flat, const MachineOptions& options)
      : flat_(flat), shader_(flat.code), options_(options) {}
  bool run(Executable& executable, std::string& error);

 private:
  using Register = int32_t;
  static constexpr Register kNoRegister = -1;
  struct RegisterFacts {
    uint32_t cells = 0;
    bool isUniform = false, isFixed = false;  // fixed: cells that point elsewhere
    int32_t first = INT32_MAX, last = -1;     // instructions
    SymbolId symbol = kNone;
    uint32_t cell = 0;
  };
  // A value in a register, or a part of one.
  struct Operand {
    Register reg = kNoRegister;
    uint32_t at = 0, components = 1, elements = 1;  // of an array; components of one element
    Base base = Base::Float;
    bool varies = false, derivs = false;
    uint32_t cells() const { return components * elements; }
  };
  struct Target {
    Operand out, final;  // where the kernel writes, where the value goes
    bool once = false, blends = false, spreads = false, copies = false;
  };
  struct Relocation {
    uint32_t word;
    Register reg;
  };
  struct Loop {
    int32_t first, last, region;
  };
  struct Scope {  // a loop, a loop's body or a function's body that code can leave
    int32_t region;
    std::vector<size_t> jumps;
  };

  // codegen.cpp: registers, words, layout
  Register newRegister(uint32_t cells, bool isUniform);
  Operand temporary(Base, uint32_t components, bool varies, bool derivs = false);
  Operand operand(SymbolId);
  Operand part(Operand, uint32_t component) const;
  Operand constant(float);
  Operand constantInt(int32_t);
  Register zeros();
  void word(uint32_t w) { e_->words_.push_back(w); }
  void reference(Register reg, uint32_t at = 0);
  size_t emit(KernelName, bool once);
  size_t emitJump(Step, Register condition = kNoRegister, Register mask = kNoRegister);
  void land(size_t jump) { e_->code_[jump].target = uint32_t(e_->code_.size()); }
  void touch(Register reg, int32_t instruction);
  Target begin(SymbolId result, bool isUniform, std::initializer_list<Operand> operands, bool elementwise = true);
  void finish(const Target&);
  void plainWords(const Operand&, uint32_t wanted);
  void mixedWords(const Operand&, uint32_t wanted);
  void dualWords(const Operand&, uint32_t wanted);
  void dualMixedWords(const Operand&, uint32_t wanted);
  void resultWords(const Operand&, bool dual);
  void clearDerivs(const Operand&, bool once);
  void copyCells(Register to, uint32_t toAt, Register from, uint32_t fromAt, uint32_t n, bool fromVaries,
                 uint32_t step);
  uint32_t site(const Instruction&, std::string name = {});
  void fail(const Instruction&, const std::string& what);
  bool layOut();
  void bindSymbols();

  // codegen_control.cpp
  void block(const Block&, int32_t region);
  void branch(const Instruction&, int32_t region);
  void loop(const Instruction&, int32_t region);
  void call(const Instruction&, int32_t region);
  void leave(int32_t region, int32_t target);
  Register maskOf(int32_t region);
  void useChunks(int32_t region);
  Register condition(const Operand&);
  Operand asInt(Operand);

  // codegen_fused.cpp
  void findFused();
  void findFused(const Block&);
  const Instruction* makerOf(const Block&, size_t reader, SymbolId, uint32_t readers = 1) const;
  bool isChangedBetween(const Block&, size_t maker, size_t reader, const Instruction&) const;
  bool joins(const Instruction& maker, const Instruction& reader) const;
  bool joinsAll(const Block&, size_t maker) const;
  bool isCondition(const Instruction&) const;
  Condition conditionOf(const Instruction&) const;
  bool isFused(const Instruction& in) const {
    return !in.arguments.empty() && fused_[size_t(in.arguments[0])] == &in;
  }
  void conditionWords(const Instruction&);
  void narrowMask(SymbolId condition, int32_t region, Register any);
  bool pair(const Instruction&, Arithmetic);
  bool choose(const Instruction&);

  // codegen_elements.cpp
  void construct(const Instruction&);
  void componentRead(const Instruction&);
  void componentWrite(const Instruction&);
  void arrayRead(const Instruction&, SymbolId result, Operand array, Operand index, const std::string& name);
  void arrayWrite(const Instruction&, SymbolId array, Operand whole, Operand index, Operand value,
                  const std::string& name);
  Operand checkedIndex(const Instruction&, Operand index, uint32_t length, const std::string& name);
  Operand matrixIndex(const Instruction&, SymbolId row, SymbolId column, const std::string& name);

  // codegen_operations.cpp, codegen_arithmetic.cpp
  void operation(const Instruction&);
  Operand number(SymbolId s) { return asFloat(operand(s)); }
  Operand asFloat(Operand);
  Operand asMatrix(Operand);
  void assign(const Instruction&, SymbolId to, Operand from);
  void arithmetic(const Instruction&, Arithmetic, Integer);
  void matrixArithmetic(const Instruction&, Operand a, Operand b);
  void unary(const Instruction&, Math, bool hasDual);
  void mixed(const Instruction&, Mixed, uint32_t firstOperand, uint32_t operands);
  void integers(const Instruction&, Integer);
  void integerUnary(const Instruction&, Integer);
  void compare(const Instruction&, Mixed floats, Mixed ints);
  void vector(const Instruction&, Vector, uint32_t operands, bool hasDual);
  void derivative(const Instruction&, int axis);
  void swept(const Instruction&);
  void transform(const Instruction&, Vector kernel, bool isNormal);
  Operand matrixBetween(const Instruction&, SymbolId from, SymbolId to);
  void scalar(const Instruction&, Scalar, std::string name = {}, uint32_t extra = 0);
  void noise(const Instruction&);
  void gabor(const Instruction&, const std::vector<Operand>& numbers, size_t n, bool periodic, size_t firstOption);
  void spline(const Instruction&);
  void transformColor(const Instruction&, SymbolId result, Operand color, const std::string* from,
                      const std::string* to, bool isConstructor);
  void spectral(const Instruction&, Spectral);
  std::string nameOf(const Instruction& in) const {
    return in.name < 0 ? std::string() : flat_.names[size_t(in.name)];
  }
  const std::string* constantString(SymbolId) const;
  bool constantInt(SymbolId, int32_t&) const;

  const FlatProgram& flat_;
  const Shader& shader_;
  const MachineOptions& options_;
  Analysis a_;
  Executable* e_ = nullptr;
  std::string error_;
  std::vector<RegisterFacts> registers_;
  std::vector<Register> ofSymbol_;
  std::vector<Relocation> relocations_;
  std::vector<size_t> firstRelocation_;  // by instruction
  std::vector<std::pair<size_t, Register>> jumpConditions_;
  std::vector<Loop> loops_;
  std::vector<Scope> scopes_;
  std::vector<Register> masks_, chunks_;  // by region; chunks_: those with points of the mask
  std::vector<std::pair<Register, std::vector<uint32_t>>> images_;
  std::vector<std::pair<Register, Register>> copiedIn_;  // arrays that come from outside
  std::vector<const Instruction*> fused_;  // by symbol: what makes it, when its readers do that in passing
  struct Uses {
    uint32_t reads = 0, writes = 0;
  };
  std::vector<Uses> uses_;  // by symbol
  Register zeros_ = kNoRegister, rootMask_ = kNoRegister;
  int32_t region_ = 0;  // of the code being made
  size_t wordsDone_ = 0;
};

}  // namespace kinora::language
