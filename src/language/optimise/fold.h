// The value of an operation on constants, computed by the machine itself at width 1: the same kernels, the same bits.
#pragma once
#include <memory>

#include "language/optimise/group.h"

namespace kinora::language {

class Folder {
 public:
  Folder(Shader& shader, ConstantPool& pool);
  ~Folder();
  // The constant that an instruction's one result would have; kNone: its operands are not all constant, it has more
  // results, or it depends on more than them.
  SymbolId fold(const Instruction&);
  SymbolId convert(SymbolId constant, const Type&);  // as an assignment would

 private:
  SymbolId evaluate(const Instruction&, const Type& result);
  Shader& shader_;
  ConstantPool& pool_;
  struct Machine;
  std::unique_ptr<Machine> machine_;
};

}  // namespace kinora::language
