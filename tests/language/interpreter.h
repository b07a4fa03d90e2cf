// A slow interpreter of the intermediate form, one point at a time: the oracle for the group machine. It walks the
// tree, computes with the standard library's functions or the formulas of the reference, carries derivatives as dual
// numbers of its own, and shares no code with src/language/vm and src/language/library. Values are rounded to float
// after each operation, as the language has them; functions beyond + - * / are right to a few units of the last
// place, not to the bit.
#pragma once
#include <map>
#include <string>
#include <vector>

#include "language/program/program.h"

namespace kinora::oracle {

struct Dual {
  double v = 0, dx = 0, dy = 0;  // v is always a float
};

struct Cells {  // one symbol at one point: numbers, ints or strings by its type
  std::vector<Dual> numbers;
  std::vector<int32_t> ints;
  std::vector<std::string> strings;
};

class Interpreter {
 public:
  explicit Interpreter(const language::Shader& shader) : shader_(shader) {}
  // Globals and instance values by name; what is not given is zero, or the default.
  std::map<std::string, Cells> given;
  // Relative error put into every result of a function: programs whose answer it changes are ill-conditioned.
  double disturbance = 0;
  int64_t instructionLimit = 1000000;

  // "" or why it gave up: an operation that it does not know, the limit.
  std::string run();
  const Cells& of(const std::string& symbol) const { return cells_[size_t(shader_.find(symbol))]; }
  const std::string& printed() const { return printed_; }

 private:
  enum class Flow { On, Break, Continue, Return, Exit };
  Flow block(const language::Block& b);
  Flow loop(const language::Instruction& i);
  void operation(const language::Instruction& i);
  bool core(const language::Instruction& i);
  bool math(const language::Instruction& i);
  bool geometry(const language::Instruction& i);
  bool strings(const language::Instruction& i);
  bool patterns(const language::Instruction& i);

  const language::Type& type(size_t argument) const {
    return shader_.symbols[size_t(now_->arguments[argument])].type;
  }
  Cells& cells(size_t argument) { return cells_[size_t(now_->arguments[argument])]; }
  size_t components(size_t argument) const;            // of one element
  Dual number(size_t argument, size_t component = 0);  // ints and single numbers serve for every component
  int32_t integer(size_t argument) { return cells(argument).ints[0]; }
  const std::string& text(size_t argument) { return cells(argument).strings[0]; }
  void set(size_t argument, size_t component, Dual d);
  std::string formatted(size_t first);
  std::vector<Dual> vector(size_t argument) {
    return {number(argument, 0), number(argument, 1), number(argument, 2)};
  }

  const language::Shader& shader_;
  const language::Instruction* now_ = nullptr;
  std::vector<Cells> cells_;
  std::string printed_, why_;
  int64_t left_ = 0;
};

// Of the reference, section 1 and 2; tests of noises use them as they are.
uint32_t hashOf(const std::vector<uint32_t>& words);
std::vector<Dual> perlin(const std::vector<Dual>& at, size_t components);

}  // namespace kinora::oracle
