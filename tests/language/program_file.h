// A program with what it must give, as tests/language/programs holds them: OSL source whose comments say
//   // expect NAME FORMULA [~TOLERANCE]   an output at each point (expression.h); u, v, P, N, time and the literal
//   defaults
//                                         of parameters are variables. |got - expected| <= TOLERANCE * max(1,
//                                         |expected|); 1e-6 unless said, 0 for ints
//   // expect NAME "TEXT"                 a string
//   // prints [when FORMULA] "TEXT"       what each point says, in order; {FORMULA} inside is printed as %g prints
//   // tells [when FORMULA] "TEXT"        an error that is told once a run: by the first point that has cause
//   // difference F FX FY [~TOLERANCE]    outputs FX and FY are the derivatives of output F: compared with central
//                                         differences of the same program at shifted points (2e-3 unless said)
//   // roads NAME...                      of: folded uniform varying, what parameters are (all three unless said)
//   // alike no                           the roads may differ in the last bits (said why)
//   // layer NAME                         begins a shader of a network, which run in the order of the file; the last
//   one
//                                         has the outputs. // connect a.f b.x
#pragma once
#include <memory>
#include <string>
#include <vector>

#include "language/optimise/group.h"

namespace kinora::oracle {

struct Expected {
  std::string output, formula, text;
  bool isText = false;
  double tolerance = -1;
  int line = 0;
};
struct Said {
  std::string when, text;
  bool isOnce = false;
};
struct Difference {
  std::string of, x, y;
  double tolerance = 2e-3;
};

struct ProgramFile {
  std::string name, source;  // name: folder/file.osl
  std::vector<Expected> expected;
  std::vector<Said> said;
  std::vector<Difference> differences;
  bool isFolded = true, isUniform = true, isVarying = true, isAlike = true;
  std::vector<std::shared_ptr<const language::Shader>> shaders;
  std::vector<std::string> uses;  // of library functions and operators (language/front/compile.h)
  language::ShaderGroup group;    // parameters with their defaults
  std::string wrong;              // "" or why it cannot be used
};

std::vector<ProgramFile> readPrograms();  // all of tests/language/programs, by name

}  // namespace kinora::oracle
