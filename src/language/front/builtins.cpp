#include "language/front/builtins.h"

#include <algorithm>
#include <vector>

namespace kinora::language::front {

namespace {

// reference: osl, section 7b; MaterialX closures as OSL's header names them
constexpr Builtin kTable[] = {
    {"Dx", Opcode::DerivX, "ff cc vp vv vn"},
    {"Dy", Opcode::DerivY, "ff cc vp vv vn"},
    {"Dz", Opcode::DerivZ, "ff cc vp vv vn"},
    {"abs", Opcode::Abs, "TT ii"},
    {"absorption", Opcode::MakeClosure, "C@"},
    {"acos", Opcode::Acos, "TT"},
    {"anisotropic_vdf", Opcode::MakeClosure, "Cccf@"},
    {"area", Opcode::Area, "fp"},
    {"arraylength", Opcode::ArrayLength, "i?"},
    {"ashikhmin_velvet", Opcode::MakeClosure, "Cnf@"},
    {"asin", Opcode::Asin, "TT"},
    {"atan", Opcode::Atan, "TT"},
    {"atan2", Opcode::Atan2, "TTT"},
    {"backfacing", Opcode::Backfacing, "i"},
    {"background", Opcode::MakeClosure, "C@"},
    {"blackbody", Opcode::Blackbody, "cf"},
    {"bssrdf_cubic", Opcode::MakeClosure, "Cc@"},
    {"burley_diffuse_bsdf", Opcode::MakeClosure, "Cncf@"},
    {"calculatenormal", Opcode::CalculateNormal, "vp"},
    {"cbrt", Opcode::Cbrt, "TT"},
    {"ceil", Opcode::Ceil, "TT"},
    {"cellnoise", Opcode::CellNoise, "Tf Tff Tp Tpf"},
    {"chiang_hair_bsdf", Opcode::MakeClosure, "C*"},
    {"clamp", Opcode::Clamp, "TTTT iiii"},
    {"concat", Opcode::Concat, "ss+"},
    {"conductor_bsdf", Opcode::MakeClosure, "Cnvffccs@"},
    {"cos", Opcode::Cos, "TT"},
    {"cosh", Opcode::Cosh, "TT"},
    {"cross", Opcode::Cross, "vvv"},
    {"debug", Opcode::MakeClosure, "Cs@"},
    {"degrees", Opcode::Degrees, "TT"},
    {"determinant", Opcode::Determinant, "fm"},
    {"dict_find", Opcode::DictFind, "iss iis"},
    {"dict_next", Opcode::DictNext, "ii"},
    {"dict_value", Opcode::DictValue, "iis!?"},
    {"dielectric_bsdf", Opcode::MakeClosure, "Cnvccfffs@"},
    {"diffuse", Opcode::MakeClosure, "Cn@"},
    {"diffuse_ramp", Opcode::MakeClosure, "Cnc[@"},
    {"distance", Opcode::Distance, "fpp"},
    {"dot", Opcode::Dot, "fvv"},
    {"emission", Opcode::MakeClosure, "C@ Cf@ Cff@"},
    {"endswith", Opcode::EndsWith, "iss"},
    {"environment", Opcode::Environment, "fsv@ csv@ fsvvv@ csvvv@"},
    {"erf", Opcode::Erf, "ff"},
    {"erfc", Opcode::Erfc, "ff"},
    {"error", Opcode::Error, "xs*"},
    {"exit", Opcode::Exit, "x"},
    {"exp", Opcode::Exp, "TT"},
    {"exp2", Opcode::Exp2, "TT"},
    {"expm1", Opcode::Expm1, "TT"},
    {"fabs", Opcode::Fabs, "TT ii"},
    {"faceforward", Opcode::FaceForward, "vvvv vvv"},
    {"filterwidth", Opcode::FilterWidth, "ff vp vv"},
    {"floor", Opcode::Floor, "TT"},
    {"fmod", Opcode::Fmod, "TTT VVf"},
    {"format", Opcode::Format, "ss*"},
    {"fprintf", Opcode::Fprintf, "xss*"},
    {"generalized_schlick_bsdf", Opcode::MakeClosure, "Cnvccffccfs@"},
    {"getattribute", Opcode::GetAttribute, "is!? iss!? isi!? issi!?"},
    {"getchar", Opcode::GetChar, "isi"},
    {"getmatrix", Opcode::GetMatrix, "iss!m is!m"},
    {"getmessage", Opcode::GetMessage, "is!? iss!?"},
    {"gettextureinfo", Opcode::GetTextureInfo, "iss!? isffs!?"},
    {"hair_diffuse", Opcode::MakeClosure, "Cv@"},
    {"hair_specular", Opcode::MakeClosure, "Cvff@"},
    {"hash", Opcode::Hash, "ii if iff ip ipf is"},
    {"hashnoise", Opcode::HashNoise, "Tf Tff Tp Tpf"},
    {"henyey_greenstein", Opcode::MakeClosure, "Cf@"},
    {"holdout", Opcode::MakeClosure, "C@"},
    {"inversesqrt", Opcode::InverseSqrt, "TT"},
    {"isconnected", Opcode::IsConnected, "i?"},
    {"isconstant", Opcode::IsConstant, "i?"},
    {"isfinite", Opcode::IsFinite, "if"},
    {"isinf", Opcode::IsInf, "if"},
    {"isnan", Opcode::IsNan, "if"},
    {"isotropic", Opcode::MakeClosure, "C@"},
    {"layer", Opcode::MakeClosure, "CCC@"},
    {"length", Opcode::Length, "fv"},
    {"linearstep", Opcode::LinearStep, "TTTT"},
    {"log", Opcode::Log, "TT fff ccf ppf vvf"},
    {"log10", Opcode::Log10, "TT"},
    {"log2", Opcode::Log2, "TT"},
    {"logb", Opcode::Logb, "TT"},
    {"luminance", Opcode::Luminance, "fc"},
    {"max", Opcode::Max, "TTT iii"},
    {"medium_vdf", Opcode::MakeClosure, "Ccfcffi@"},
    {"microfacet", Opcode::MakeClosure, "Csnffi@ Csnvfffi@"},
    {"min", Opcode::Min, "TTT iii"},
    {"mix", Opcode::Mix, "TTTT VVVf"},
    {"mod", Opcode::FloorMod, "TTT VVf iii"},
    {"noise", Opcode::Noise, "Tf Tff Tp Tpf Tsf@ Tsff@ Tsp@ Tspf@"},
    {"normalize", Opcode::Normalize, "vv nn"},
    {"oren_nayar", Opcode::MakeClosure, "Cnf@"},
    {"oren_nayar_diffuse_bsdf", Opcode::MakeClosure, "Cncf@"},
    {"phong", Opcode::MakeClosure, "Cnf@"},
    {"phong_ramp", Opcode::MakeClosure, "Cnfc[@"},
    {"pnoise", Opcode::PNoise, "Tff Tffff Tpp Tpfpf Tsff@ Tsffff@ Tspp@ Tspfpf@"},
    {"pointcloud_get", Opcode::PointCloudGet, "isi[is!?"},
    {"pointcloud_search", Opcode::PointCloudSearch, "ispfi*"},
    {"pointcloud_write", Opcode::PointCloudWrite, "isp*"},
    {"pow", Opcode::Pow, "TTT VVf"},
    {"printf", Opcode::Printf, "xs*"},
    {"psnoise", Opcode::PSNoise, "Tff Tffff Tpp Tpfpf"},
    {"radians", Opcode::Radians, "TT"},
    {"raytype", Opcode::RayType, "is"},
    {"reflect", Opcode::Reflect, "vvv"},
    {"reflection", Opcode::MakeClosure, "Cn@ Cnf@"},
    {"refract", Opcode::Refract, "vvvf"},
    {"refraction", Opcode::MakeClosure, "Cnf@"},
    {"regex_match", Opcode::RegexMatch, "iss is!i[s"},
    {"regex_search", Opcode::RegexSearch, "iss is!i[s"},
    {"rotate", Opcode::Rotate, "ppfpp ppfv"},
    {"round", Opcode::Round, "TT"},
    {"select", Opcode::Select, "TTTT VVVf TTTi"},
    {"setmessage", Opcode::SetMessage, "xs?"},
    {"sheen_bsdf", Opcode::MakeClosure, "Cncf@"},
    {"sign", Opcode::Sign, "TT"},
    {"sin", Opcode::Sin, "TT"},
    {"sincos", Opcode::SinCos, "xT!T!T"},
    {"sinh", Opcode::Sinh, "TT"},
    {"smooth_linearstep", Opcode::SmoothLinearStep, "TTTTT"},
    {"smoothstep", Opcode::SmoothStep, "TTTT"},
    {"snoise", Opcode::SNoise, "Tf Tff Tp Tpf"},
    {"spline", Opcode::Spline, "TsfT+ TsfT[ TsfiT["},
    {"splineinverse", Opcode::SplineInverse, "fsff+ fsff[ fsfif["},
    {"split", Opcode::Split, "is!s[ is!s[s is!s[si"},
    {"sqrt", Opcode::Sqrt, "TT"},
    {"startswith", Opcode::StartsWith, "iss"},
    {"step", Opcode::Step, "TTT"},
    {"stof", Opcode::StoF, "fs"},
    {"stoi", Opcode::StoI, "is"},
    {"strlen", Opcode::Strlen, "is"},
    {"substr", Opcode::Substr, "ssi ssii"},
    {"subsurface", Opcode::MakeClosure, "C@ Cffff@ Cffcc@"},
    {"subsurface_bssrdf", Opcode::MakeClosure, "Cnccf@ Cncfcf@"},
    {"surfacearea", Opcode::SurfaceArea, "f"},
    {"tan", Opcode::Tan, "TT"},
    {"tanh", Opcode::Tanh, "TT"},
    {"texture", Opcode::Texture, "fsff@ csff@ fsffffff@ csffffff@"},
    {"texture3d", Opcode::Texture3d, "fsp@ csp@ fspvvv@ cspvvv@"},
    {"trace", Opcode::Trace, "ipv@"},
    {"transform", Opcode::TransformPoint, "GmG GsG GssG"},
    {"transformc", Opcode::TransformColor, "csc cssc"},
    {"translucent", Opcode::MakeClosure, "Cn@"},
    {"translucent_bsdf", Opcode::MakeClosure, "Cnc@"},
    {"transparent", Opcode::MakeClosure, "C@"},
    {"transparent_bsdf", Opcode::MakeClosure, "C@"},
    {"transpose", Opcode::Transpose, "mm"},
    {"trunc", Opcode::Trunc, "TT"},
    {"uniform_edf", Opcode::MakeClosure, "Cc@"},
    {"ward", Opcode::MakeClosure, "Cnvff@"},
    {"warning", Opcode::Warning, "xs*"},
    {"wavelength_color", Opcode::WavelengthColor, "cf"},
    {"westin_backscatter", Opcode::MakeClosure, "Cnf@"},
    {"westin_sheen", Opcode::MakeClosure, "Cnf@"},
};
static_assert(std::is_sorted(std::begin(kTable), std::end(kTable),
                             [](const Builtin& a, const Builtin& b) { return a.name < b.name; }));

Base baseOf(char c) {
  switch (c) {
    case 'i':
      return Base::Int;
    case 'f':
      return Base::Float;
    case 's':
      return Base::String;
    case 'c':
      return Base::Color;
    case 'p':
      return Base::Point;
    case 'v':
      return Base::Vector;
    case 'n':
      return Base::Normal;
    case 'm':
      return Base::Matrix;
    case 'C':
      return Base::Closure;
    default:
      return Base::Void;
  }
}

std::vector<Signature> signaturesIn(std::string_view texts) {
  std::vector<Signature> all;
  while (!texts.empty()) {
    const std::string_view text = texts.substr(0, texts.find(' '));
    texts.remove_prefix(std::min(texts.size(), text.size() + 1));
    std::string_view letters = " ";
    char family = 0;
    for (const auto& [f, l] : {std::pair<char, std::string_view>{'T', "fcpvn"}, {'V', "cpvn"}, {'G', "pvn"}})
      if (text.find(f) != std::string_view::npos) family = f, letters = l;
    for (const char letter : letters) {
      Signature& made = all.emplace_back();
      bool isOutput = false, hasResult = false;
      for (const char c : text) {
        if (c == '!') {
          isOutput = true;
        } else if (c == '[') {
          made.formals[made.count - 1].type.arrayLength = -1;
        } else if (c == '+' || c == '*' || c == '@') {
          made.rest = c;
        } else if (!hasResult) {
          made.result.base = baseOf(c == family ? letter : c);
          hasResult = true;
        } else {
          Formal& f = made.formals[made.count++];
          f.isAny = c == '?';
          f.type.base = baseOf(c == family ? letter : c);
          f.isOutput = isOutput;
          isOutput = false;
        }
      }
    }
  }
  return all;
}

bool isGeometric(Base b) { return b == Base::Point || b == Base::Vector || b == Base::Normal; }

}  // namespace

std::span<const Builtin> allBuiltins() { return kTable; }

const Builtin* builtinNamed(std::string_view name) {
  const auto* at = std::lower_bound(std::begin(kTable), std::end(kTable), name,
                                    [](const Builtin& b, std::string_view n) { return b.name < n; });
  return at != std::end(kTable) && at->name == name ? at : nullptr;
}

std::span<const Signature> signaturesOf(const Builtin& builtin) {
  static const std::vector<std::vector<Signature>> kAll = [] {
    std::vector<std::vector<Signature>> all;
    for (const Builtin& b : kTable) all.push_back(signaturesIn(b.signatures));
    return all;
  }();
  return kAll[size_t(&builtin - kTable)];
}

// reference: osl-numerics, section 11
bool assignable(const Type& to, const Type& from) {
  if (to.base == Base::Struct || from.base == Base::Struct || to.base == Base::Closure ||
      from.base == Base::Closure || to.base == Base::String || from.base == Base::String || to.base == Base::Void ||
      from.base == Base::Void) {
    if (to.base != from.base || to.structure != from.structure || to.base == Base::Void) return false;
  }
  if (to.arrayLength != 0 || from.arrayLength != 0) {
    if (to.arrayLength == 0 || from.arrayLength == 0) return false;
    if (to.arrayLength > 0 && from.arrayLength > to.arrayLength) return false;
    return to.base == from.base || (isTriple(to.base) && isTriple(from.base));
  }
  if (to.base == from.base) return true;
  if (isTriple(to.base) && isTriple(from.base)) return true;
  if (from.base == Base::Int) return to.base == Base::Float || isTriple(to.base) || to.base == Base::Matrix;
  if (from.base == Base::Float) return isTriple(to.base) || to.base == Base::Matrix;
  return false;
}

int matchScore(const Type& formal, const Type& actual) {
  if (formal == actual) return 100;
  if (!assignable(formal, actual)) return 0;
  if (formal.arrayLength != 0) {
    if (formal.arrayLength > 0 && formal.arrayLength != actual.arrayLength) return 0;
    return formal.base == actual.base ? 44 : 0;
  }
  if (formal.base == Base::Float && actual.base == Base::Int) return 77;
  if (isGeometric(formal.base) && isGeometric(actual.base)) return 32;
  if (isTriple(formal.base) && isTriple(actual.base)) return 27;
  return 23;
}

}  // namespace kinora::language::front
