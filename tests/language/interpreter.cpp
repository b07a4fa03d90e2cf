// Control flow and the core of the language; interpreter_math.cpp and interpreter_noise.cpp have the library.
#include "language/interpreter.h"

#include <cmath>
#include <cstdio>

#include "language/dual_arithmetic.h"

namespace kinora::oracle {

using namespace language;

size_t Interpreter::components(size_t argument) const { return size_t(componentsOf(type(argument).base)); }

Dual Interpreter::number(size_t argument, size_t component) {
  const Cells& c = cells(argument);
  if (type(argument).base == Base::Int) return {double(float(c.ints[0])), 0, 0};
  return c.numbers[c.numbers.size() == 1 ? 0 : component];
}

void Interpreter::set(size_t argument, size_t component, Dual d) {
  if (type(argument).base == Base::Matrix) d.dx = d.dy = 0;
  cells(argument).numbers[component] = d;
}

std::string Interpreter::run() {
  cells_.assign(shader_.symbols.size(), {});
  why_.clear();
  printed_.clear();
  left_ = instructionLimit;
  for (size_t i = 0; i < cells_.size(); ++i) {
    const Symbol& s = shader_.symbols[i];
    const size_t n = s.type.arrayLength > 0 ? size_t(s.type.arrayLength) : 1;
    Cells& c = cells_[i];
    if (s.type.base == Base::Int)
      c.ints = s.values.ints;
    else if (s.type.base == Base::String)
      c.strings = s.values.strings;
    else
      for (const float f : s.values.floats) c.numbers.push_back({double(f), 0, 0});
    if (s.values.empty()) {
      if (s.type.base == Base::Int) c.ints.assign(n, 0);
      if (s.type.base == Base::String) c.strings.assign(n, "");
      c.numbers.assign(n * size_t(componentsOf(s.type.base)), {});
    }
    if (const auto g = given.find(s.name); g != given.end() && s.kind != SymbolKind::Constant) c = g->second;
  }
  for (const Initialiser& i : shader_.initialisers)
    if (!given.contains(shader_.symbols[size_t(i.parameter)].name)) block(i.code);
  block(shader_.main);
  return why_;
}

Interpreter::Flow Interpreter::block(const Block& b) {
  for (const Instruction& i : b.code) {
    if (!why_.empty() || --left_ < 0) {
      if (why_.empty()) why_ = "too many instructions";
      return Flow::Exit;
    }
    Flow flow = Flow::On;
    switch (i.opcode) {
      case Opcode::If:
        flow = block(i.blocks[cells_[size_t(i.arguments[0])].ints[0] ? 0 : 1]);
        break;
      case Opcode::For:
      case Opcode::While:
      case Opcode::DoWhile:
        flow = loop(i);
        break;
      case Opcode::Call:
        flow = block(i.blocks[0]);
        if (flow == Flow::Return) flow = Flow::On;
        break;
      case Opcode::Break:
        return Flow::Break;
      case Opcode::Continue:
        return Flow::Continue;
      case Opcode::Return:
        return Flow::Return;
      case Opcode::Exit:
        return Flow::Exit;
      case Opcode::Nop:
      case Opcode::End:
        break;
      default:
        operation(i);
    }
    if (flow != Flow::On) return flow;
  }
  return Flow::On;
}

Interpreter::Flow Interpreter::loop(const Instruction& i) {
  const size_t condition = size_t(i.arguments[0]);
  if (const Flow f = block(i.blocks[0]); f != Flow::On) return f;
  for (bool isFirst = i.opcode == Opcode::DoWhile;; isFirst = false) {
    if (--left_ < 0) {  // a body may be empty
      if (why_.empty()) why_ = "too many instructions";
      return Flow::Exit;
    }
    if (!isFirst) {
      if (const Flow f = block(i.blocks[1]); f != Flow::On) return f;
      if (!cells_[condition].ints[0]) return Flow::On;
    }
    const Flow f = block(i.blocks[2]);
    if (f == Flow::Break) return Flow::On;
    if (f == Flow::Return || f == Flow::Exit) return f;
    if (const Flow s = block(i.blocks[3]); s != Flow::On) return s;
  }
}

void Interpreter::operation(const Instruction& i) {
  now_ = &i;
  if (!core(i) && !math(i) && !geometry(i) && !strings(i) && !patterns(i))
    why_ = "operation " + std::string(factsOf(i.opcode).name) + " is not interpreted";
}

namespace {

size_t clamped(int32_t i, size_t n) { return i < 0 ? 0 : size_t(i) >= n ? n - 1 : size_t(i); }

int32_t whole(double v) { return v >= -2147483648.0 && v < 2147483648.0 ? int32_t(v) : INT32_MIN; }

}  // namespace

bool Interpreter::core(const Instruction& i) {
  const size_t n = i.arguments.empty() ? 0 : components(0);
  const auto wide = [](int32_t a) { return uint32_t(a); };
  switch (i.opcode) {
    case Opcode::Assign:
      if (type(0).base == Base::String) {
        cells(0).strings[0] = text(1);
      } else if (type(0).base == Base::Int) {
        cells(0).ints[0] = type(1).base == Base::Int ? integer(1) : whole(number(1).v);
      } else if (type(0).base == Base::Matrix && type(1).base != Base::Matrix) {
        const Dual d = number(1);
        for (size_t k = 0; k < 16; ++k) set(0, k, k % 5 == 0 ? d : Dual());
      } else {
        for (size_t k = 0; k < n; ++k) set(0, k, number(1, k));
      }
      return true;
    case Opcode::ArrayCopy: {
      const Cells from = cells(1);
      for (size_t k = 0; k < from.numbers.size(); ++k) cells(0).numbers[k] = from.numbers[k];
      for (size_t k = 0; k < from.ints.size(); ++k) cells(0).ints[k] = from.ints[k];
      for (size_t k = 0; k < from.strings.size(); ++k) cells(0).strings[k] = from.strings[k];
      return true;
    }
    case Opcode::ArrayRef: {
      const size_t at = clamped(integer(2), size_t(type(1).arrayLength));
      if (type(0).base == Base::Int)
        cells(0).ints[0] = cells(1).ints[at];
      else if (type(0).base == Base::String)
        cells(0).strings[0] = cells(1).strings[at];
      else
        for (size_t k = 0; k < n; ++k) set(0, k, cells(1).numbers[at * n + k]);
      return true;
    }
    case Opcode::ArrayAssign: {
      const size_t at = clamped(integer(1), size_t(type(0).arrayLength));
      if (type(0).base == Base::Int)
        cells(0).ints[at] = integer(2);
      else if (type(0).base == Base::String)
        cells(0).strings[at] = text(2);
      else
        for (size_t k = 0; k < n; ++k) cells(0).numbers[at * n + k] = number(2, k);
      return true;
    }
    case Opcode::ComponentRef:
      set(0, 0, cells(1).numbers[clamped(integer(2), 3)]);
      return true;
    case Opcode::ComponentAssign:
      set(0, clamped(integer(1), 3), number(2));
      return true;
    case Opcode::MatrixRef:
      set(0, 0, {cells(1).numbers[4 * clamped(integer(2), 4) + clamped(integer(3), 4)].v, 0, 0});
      return true;
    case Opcode::MatrixAssign:
      set(0, 4 * clamped(integer(1), 4) + clamped(integer(2), 4), number(3));
      return true;
    case Opcode::ArrayLength:
      cells(0).ints[0] = type(1).arrayLength;
      return true;
    case Opcode::Add:
    case Opcode::Sub:
    case Opcode::Mul:
    case Opcode::Div: {
      if (type(0).base == Base::Closure) return false;
      if (type(0).base == Base::Matrix) return geometry(i);
      if (type(0).base == Base::Int) {
        const int32_t a = integer(1), b = integer(2);
        cells(0).ints[0] = i.opcode == Opcode::Add   ? int32_t(wide(a) + wide(b))
                           : i.opcode == Opcode::Sub ? int32_t(wide(a) - wide(b))
                           : i.opcode == Opcode::Mul ? int32_t(wide(a) * wide(b))
                           : b == 0                  ? 0
                           : b == -1                 ? int32_t(0 - wide(a))
                                                     : a / b;
        return true;
      }
      std::vector<Dual> r(n);
      for (size_t k = 0; k < n; ++k) {
        const Dual a = number(1, k), b = number(2, k);
        r[k] = i.opcode == Opcode::Add   ? a + b
               : i.opcode == Opcode::Sub ? a - b
               : i.opcode == Opcode::Mul ? a * b
                                         : a / b;
      }
      for (size_t k = 0; k < n; ++k) set(0, k, r[k]);
      return true;
    }
    case Opcode::Neg:
      if (type(0).base == Base::Int)
        cells(0).ints[0] = int32_t(0 - wide(integer(1)));
      else
        for (size_t k = 0; k < n; ++k) set(0, k, -number(1, k));
      return true;
    case Opcode::Mod:
    case Opcode::BitAnd:
    case Opcode::BitOr:
    case Opcode::BitXor:
    case Opcode::ShiftLeft:
    case Opcode::ShiftRight:
    case Opcode::And:
    case Opcode::Or: {
      const int32_t a = integer(1), b = integer(2);
      int32_t r = 0;
      if (i.opcode == Opcode::Mod) r = b == 0 || b == -1 ? 0 : a % b;
      if (i.opcode == Opcode::BitAnd) r = a & b;
      if (i.opcode == Opcode::BitOr) r = a | b;
      if (i.opcode == Opcode::BitXor) r = a ^ b;
      if (i.opcode == Opcode::ShiftLeft) r = int32_t(wide(a) << (b & 31));
      if (i.opcode == Opcode::ShiftRight) r = a >> (b & 31);
      if (i.opcode == Opcode::And) r = a && b;
      if (i.opcode == Opcode::Or) r = a || b;
      cells(0).ints[0] = r;
      return true;
    }
    case Opcode::Complement:
      cells(0).ints[0] = ~integer(1);
      return true;
    case Opcode::Eq:
    case Opcode::Neq: {
      bool isSame = true;
      if (type(1).base == Base::String) {
        isSame = text(1) == text(2);
      } else if (type(1).base == Base::Int && type(2).base == Base::Int) {
        isSame = integer(1) == integer(2);
      } else {
        const size_t m = std::max(components(1), components(2));
        for (size_t k = 0; k < m; ++k) {
          // a number beside a matrix is a multiple of the identity
          const auto side = [&](size_t a) {
            return m == 16 && components(a) == 1 && k % 5 != 0 ? 0.0 : number(a, k).v;
          };
          isSame &= side(1) == side(2);
        }
      }
      cells(0).ints[0] = isSame == (i.opcode == Opcode::Eq);
      return true;
    }
    case Opcode::Lt:
    case Opcode::Le:
    case Opcode::Gt:
    case Opcode::Ge: {
      const bool isInt = type(1).base == Base::Int && type(2).base == Base::Int;
      const double a = isInt ? integer(1) : number(1).v, b = isInt ? integer(2) : number(2).v;
      cells(0).ints[0] = i.opcode == Opcode::Lt   ? a < b
                         : i.opcode == Opcode::Le ? a <= b
                         : i.opcode == Opcode::Gt ? a > b
                                                  : a >= b;
      return true;
    }
    case Opcode::MakeColor:
    case Opcode::MakePoint:
    case Opcode::MakeVector:
    case Opcode::MakeNormal: {
      if (i.arguments.size() != 4) return false;
      const Dual d[3] = {number(1), number(2), number(3)};
      for (size_t k = 0; k < 3; ++k) set(0, k, d[k]);
      return true;
    }
    case Opcode::MakeMatrix: {
      if (i.arguments.size() != 2 && i.arguments.size() != 17) return false;
      std::vector<Dual> m(16);
      for (size_t k = 0; k < 16; ++k)
        m[k] = i.arguments.size() == 17 ? number(1 + k) : k % 5 == 0 ? number(1) : Dual();
      for (size_t k = 0; k < 16; ++k) set(0, k, m[k]);
      return true;
    }
    default:
      return false;
  }
}

}  // namespace kinora::oracle
