// Names of noises, bases of splines, their numbers of knots and colour spaces that are known only at run time: the
// machine has a kernel for each, so the call becomes a choice among calls, each for the points that ask for it.
#include <string_view>
#include <vector>

#include "language/library/color_system.h"
#include "language/library/noise_name.h"
#include "language/optimise/optimise.h"

namespace kinora::language {

namespace {

// Names that mean the same, the first one standing for all.
using Names = std::vector<std::string_view>;

const std::vector<Names>& splineNames() {
  static const std::vector<Names> kAll = {{"catmull-rom"}, {"bezier"}, {"bspline"}, {"hermite"}, {"constant"}};
  return kAll;
}

std::vector<Names> noiseNames(bool isPeriodic) {
  static constexpr std::string_view kSpelled[] = {
      "perlin",        "snoise", "psnoise",   "uperlin", "noise",     "pnoise", "simplex", "simplexnoise", "usimplex",
      "usimplexnoise", "cell",   "cellnoise", "hash",    "hashnoise", "gabor",  "null",    "unull"};
  std::vector<Names> all;
  std::vector<NoiseKind> kinds;
  for (const std::string_view name : kSpelled) {
    const NoiseKind kind = noiseKind(name, isPeriodic, false);
    if (kind == NoiseKind::Unknown) continue;
    size_t at = 0;
    while (at < kinds.size() && kinds[at] != kind) ++at;
    if (at == kinds.size()) {
      kinds.push_back(kind);
      all.emplace_back();
    }
    all[at].push_back(name);
  }
  return all;
}

// Not for transformc(): the constructor color("space", ...), which knows fewer.
std::vector<Names> spaceNames(bool isConstructor) {
  const std::string_view working = defaultColorSystem().name;
  std::vector<Names> all = {{"RGB", "rgb", working}, {"hsv"}, {"hsl"}, {"YIQ"}, {"XYZ"}, {"xyY"}};
  if (isConstructor) return all;
  all[0].push_back("linear");
  all.insert(all.begin(), {"sRGB"});  // means the curve, even where the working space is called so
  return all;
}

constexpr int32_t kMostCounts = 64;  // knots of an array whose number in use may be chosen

class Chooser {
 public:
  explicit Chooser(FlatProgram& flat) : shader_(flat.code), pool_(flat.code) {}

  void block(Block& code) {
    std::vector<Instruction> made;
    made.reserve(code.code.size());
    for (Instruction& in : code.code) {
      for (Block& inner : in.blocks) block(inner);
      if (const Choice choice = choiceIn(in); choice.what != Chosen::Nothing)
        choose(in, choice, made);
      else
        made.push_back(std::move(in));
    }
    code.code = std::move(made);
  }

 private:
  enum class Chosen { Nothing, Noise, Basis, Space, Count };
  struct Choice {
    Chosen what = Chosen::Nothing;
    size_t at = 0;  // the argument
  };

  bool isOpen(const Instruction& in, size_t at, Base base) const {
    const Symbol& s = shader_.symbols[size_t(in.arguments[at])];
    return s.type == Type{base, 0, -1} && s.kind != SymbolKind::Constant;
  }
  Choice choiceIn(const Instruction& in) const {
    const size_t n = in.arguments.size();
    switch (in.opcode) {
      case Opcode::Noise:
      case Opcode::PNoise:
        if (n >= 3 && isOpen(in, 1, Base::String)) return {Chosen::Noise, 1};
        break;
      case Opcode::Spline:
      case Opcode::SplineInverse:
        if (n >= 3 && isOpen(in, 1, Base::String)) return {Chosen::Basis, 1};
        if (n == 5 && isOpen(in, 3, Base::Int)) {
          const int32_t knots = shader_.symbols[size_t(in.arguments[4])].type.arrayLength;
          if (knots > 0 && knots <= kMostCounts) return {Chosen::Count, 3};
        }
        break;
      case Opcode::TransformColor:
        for (size_t i = 1; i + 1 < n; ++i)
          if (isOpen(in, i, Base::String)) return {Chosen::Space, i};
        break;
      case Opcode::MakeColor:
        if (n >= 3 && isOpen(in, 1, Base::String)) return {Chosen::Space, 1};
        break;
      default:
        break;
    }
    return {};
  }

  void choose(const Instruction& in, Choice choice, std::vector<Instruction>& out) {
    Block all;
    if (choice.what == Chosen::Count)
      chooseCount(in, 1, shader_.symbols[size_t(in.arguments[4])].type.arrayLength, all);
    else
      chooseName(in, choice, all);
    block(all);  // a call may have more to choose
    for (Instruction& i : all.code) out.push_back(std::move(i));
  }

  // By halves; fewer than one count as one, more than there are as all.
  void chooseCount(const Instruction& in, int32_t least, int32_t most, Block& out) {
    if (least == most) {
      out.code.push_back(in);
      out.code.back().arguments[3] = pool_.ofInt(least);
      return;
    }
    const int32_t middle = (least + most) / 2;
    const SymbolId holds = temporary();
    out.code.push_back(like(in, Opcode::Le, {holds, in.arguments[3], pool_.ofInt(middle)}));
    Instruction choice = like(in, Opcode::If, {holds});
    choice.blocks.resize(2);
    chooseCount(in, least, middle, choice.blocks[0]);
    chooseCount(in, middle + 1, most, choice.blocks[1]);
    out.code.push_back(std::move(choice));
  }

  // From the last choice to the first, each within the other side of the one before.
  void chooseName(const Instruction& in, Choice choice, Block& out) {
    const bool isPeriodic = in.opcode == Opcode::PNoise, isConstructor = in.opcode == Opcode::MakeColor;
    const SymbolId place = pool_.ofString(in.pos.file ? *in.pos.file : std::string()),
                   line = pool_.ofInt(int32_t(in.pos.line));
    Block rest;
    std::vector<Names> all;
    if (choice.what == Chosen::Noise) {
      all = noiseNames(isPeriodic);
      std::string text = unknownNoise("%s", isPeriodic, "", 0);
      text.resize(text.find(", called"));
      rest.code.push_back(
          like(in, Opcode::Complain, {pool_.ofString(text + ", called from (%s:%d)"), in.arguments[1], place, line}));
      rest.code.push_back(like(in, Opcode::Assign, {in.arguments[0], pool_.ofFloat(0)}));
    } else if (choice.what == Chosen::Space) {
      all = spaceNames(isConstructor);
      const SymbolId rgb = pool_.ofString("RGB");
      const bool two = !isConstructor && in.arguments.size() == 4;
      rest.code.push_back(like(in, Opcode::Complain,
                               {pool_.ofString("Unknown color space transformation \"%s\" -> \"%s\": %s:%d"),
                                two || isConstructor ? in.arguments[1] : rgb,
                                isConstructor ? rgb : in.arguments[two ? 2 : 1], place, line}));
      Instruction same = like(in, isConstructor ? Opcode::MakeColor : Opcode::Assign, in.arguments);
      same.arguments.erase(same.arguments.begin() + 1,
                           isConstructor ? same.arguments.begin() + 2 : same.arguments.end() - 1);
      rest.code.push_back(std::move(same));
    } else {
      all = splineNames();
      rest.code.push_back(called(in, choice, "linear"));  // any other name, as the reference has it
    }
    for (size_t k = all.size(); k-- > 0;) {
      Block test;
      const SymbolId holds = isAmong(in, choice, all[k], test.code);
      Instruction branch = like(in, Opcode::If, {holds});
      branch.blocks.resize(2);
      branch.blocks[0].code.push_back(called(in, choice, all[k][0]));
      branch.blocks[1] = std::move(rest);
      test.code.push_back(std::move(branch));
      rest = std::move(test);
    }
    out = std::move(rest);
  }

  SymbolId isAmong(const Instruction& in, Choice choice, const Names& names, std::vector<Instruction>& out) {
    SymbolId any = kNone;
    for (const std::string_view name : names) {
      const SymbolId one = temporary();
      out.push_back(like(in, Opcode::Eq, {one, in.arguments[choice.at], pool_.ofString(std::string(name))}));
      if (any == kNone) {
        any = one;
        continue;
      }
      const SymbolId both = temporary();
      out.push_back(like(in, Opcode::Or, {both, any, one}));
      any = both;
    }
    return any;
  }

  Instruction called(const Instruction& in, Choice choice, std::string_view name) {
    // names without a kernel of their own are numbers
    if (choice.what == Chosen::Noise && (name == "null" || name == "unull"))
      return like(in, Opcode::Assign, {in.arguments[0], pool_.ofFloat(name == "null" ? 0.f : 0.5f)});
    Instruction call = in;
    call.arguments[choice.at] = pool_.ofString(std::string(name));
    return call;
  }

  Instruction like(const Instruction& in, Opcode op, std::vector<SymbolId> arguments) const {
    Instruction made;
    made.opcode = op;
    made.arguments = std::move(arguments);
    made.pos = in.pos;
    made.layer = in.layer;
    return made;
  }

  SymbolId temporary() {
    Symbol symbol;
    symbol.name = "$choice" + std::to_string(shader_.symbols.size());
    symbol.kind = SymbolKind::Temp;
    symbol.type = {Base::Int, 0, -1};
    shader_.symbols.push_back(std::move(symbol));
    return SymbolId(shader_.symbols.size()) - 1;
  }

  Shader& shader_;
  ConstantPool pool_;
};

}  // namespace

void chooseNames(FlatProgram& flat) { Chooser(flat).block(flat.code.main); }

}  // namespace kinora::language
