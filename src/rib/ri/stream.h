// The stream of RIB that calls of the C interface (include/kinora/ri.h) become. One for the program, which runs one
// shared object. Called by the functions of functions*.cpp; it knows as much of the graphics state as the text needs:
// declared names and the steps of Basis, which decide how many values a parameter has, and the transform, which decides
// the detail of a procedural within the one that is run.
#pragma once
#include <kinora/ri.h>

#include <cstdarg>
#include <cstdint>
#include <cstdio>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "rib/declarations.h"
#include "rib/primvar_counts.h"
#include "scene/scene.h"

namespace kinora::rib::ri {

// A parameter list as the C functions take it.
struct Given {
  RtInt n = 0;
  const RtToken* tokens = nullptr;
  const RtPointer* values = nullptr;
};
// One that was given as pairs, up to RI_NULL.
class Pairs {
 public:
  explicit Pairs(va_list& list) {
    while (const RtToken token = va_arg(list, RtToken)) {
      tokens_.push_back(token);
      values_.push_back(va_arg(list, RtPointer));
    }
  }
  RtInt count() const { return RtInt(tokens_.size()); }
  RtToken* tokens() { return tokens_.data(); }
  RtPointer* values() { return values_.data(); }

 private:
  std::vector<RtToken> tokens_;
  std::vector<RtPointer> values_;
};

class Stream {
 public:
  // Where the text goes. Not standard output itself, which the shared object may print to.
  void open(std::FILE* out) { out_ = out; }
  // False: what was printed has not arrived.
  bool close();

  // A line: the request, its arguments, in any order of these calls.
  Stream& request(const char* name);
  Stream& word(const char* text);  // null: ""
  Stream& number(double x);
  Stream& integer(long x);
  Stream& floats(const RtFloat* x, size_t n);
  Stream& integers(const RtInt* x, size_t n);
  Stream& words(const RtToken* x, size_t n);
  // Its parameters; how many values each has follows from its class and the shape.
  void list(const Given& given, const PrimvarCounts& counts = {1, 1, 1, 1, 0});
  void list(const Given& given, const scene::Shape& shape, size_t positions = 0) {
    list(given, countsOf(shape, positions, steps_));
  }

  bool declare(const std::string& name, const char* declaration);
  // ---- state
  void push(bool withAttributes);
  void pop(bool withAttributes);
  scene::Matrix& transform() { return states_.back().transform; }
  void basisSteps(int u, int v) { steps_.uStep = u, steps_.vStep = v; }
  // Objects and lights have names of this stream, so that those of two procedurals are two.
  RtPointer newHandle() { return reinterpret_cast<RtPointer>(++handles_); }
  Stream& handle(RtPointer x);

  // name: what handles begin with. detail: of the bound of the request that is answered, in its space.
  void begin(std::string name, double detail, std::optional<std::span<const float, 6>> bound);
  // Detail is an area: the share of it that a bound under the transform here has. Null: calls are too deep within each
  // other (said on standard error).
  std::optional<double> enterProcedural(const RtBound bound);
  void leaveProcedural();

 private:
  struct State {
    scene::Matrix transform;
    int uStep = 3, vStep = 3;
    bool withAttributes = true;
  };
  void end();
  void print(std::string_view text);
  template <class T>
  void numberText(T v);
  template <class T, class Put>
  Stream& bracketed(const T* x, size_t n, const Put& put);
  void quoted(const char* text);

  std::FILE* out_ = stdout;
  std::string text_;
  bool isOpen_ = false, hasFailed_ = false;
  Declarations declarations_;
  scene::Attributes steps_;
  std::vector<State> states_ = {State()};
  struct Level {
    double detail, size;  // size: diagonal of the bound; 0: not known
  };
  std::vector<Level> levels_;
  std::string name_;
  intptr_t handles_ = 0;
};

Stream& stream();

}  // namespace kinora::rib::ri
