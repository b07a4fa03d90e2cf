// Which kernel does each operation, by the types of its operands.
#include "language/vm/codegen.h"

namespace kinora::language {

void CodeGenerator::operation(const Instruction& in) {
  const auto base = [&](size_t i) { return shader_.symbols[size_t(in.arguments[i])].type.base; };
  switch (in.opcode) {
    case Opcode::Assign:
      if (const Instruction* maker = fused_[size_t(in.arguments[1])]) {
        Instruction made = *maker;
        made.arguments[0] = in.arguments[0];
        return operation(made);
      }
      return assign(in, in.arguments[0], operand(in.arguments[1]));
    case Opcode::ArrayCopy:
      return assign(in, in.arguments[0], operand(in.arguments[1]));
    case Opcode::ArrayRef:
      if (base(0) == Base::Closure) return;
      return arrayRead(in, in.arguments[0], operand(in.arguments[1]), operand(in.arguments[2]), nameOf(in));
    case Opcode::ArrayAssign:
      if (base(0) == Base::Closure) return;
      return arrayWrite(in, in.arguments[0], operand(in.arguments[0]), operand(in.arguments[1]),
                        operand(in.arguments[2]), nameOf(in));
    case Opcode::CheckIndex: {
      int32_t length = 0;
      if (!constantInt(in.arguments[1], length)) return fail(in, "check_index takes a constant length");
      checkedIndex(in, operand(in.arguments[0]), uint32_t(length), nameOf(in));
      return;
    }
    case Opcode::ComponentRef:
    case Opcode::MatrixRef:
      return componentRead(in);
    case Opcode::ComponentAssign:
    case Opcode::MatrixAssign:
      return componentWrite(in);
    case Opcode::Add:
      return arithmetic(in, Arithmetic::Add, Integer::AddI);
    case Opcode::Sub:
      return arithmetic(in, Arithmetic::Sub, Integer::SubI);
    case Opcode::Mul:
      return arithmetic(in, Arithmetic::Mul, Integer::MulI);
    case Opcode::Div:
      return arithmetic(in, Arithmetic::Div, Integer::DivI);
    case Opcode::Min:
      return arithmetic(in, Arithmetic::Min, Integer::MinI);
    case Opcode::Max:
      return arithmetic(in, Arithmetic::Max, Integer::MaxI);
    case Opcode::Mod:
      return integers(in, Integer::ModI);
    case Opcode::FloorMod:
      if (base(0) == Base::Int) return integers(in, Integer::FloorModI);
      return mixed(in, Mixed::FloorMod, 1, 2);
    case Opcode::Neg:
      if (base(0) == Base::Int) return integerUnary(in, Integer::NegI);
      if (base(0) == Base::Closure) return;
      return unary(in, Math::Neg, true);
    case Opcode::BitAnd:
      return integers(in, Integer::AndBits);
    case Opcode::BitOr:
      return integers(in, Integer::OrBits);
    case Opcode::BitXor:
      return integers(in, Integer::XorBits);
    case Opcode::ShiftLeft:
      return integers(in, Integer::Shl);
    case Opcode::ShiftRight:
      return integers(in, Integer::Shr);
    case Opcode::Complement:
      return integerUnary(in, Integer::Complement);
    case Opcode::And:
      return integers(in, Integer::AndI);
    case Opcode::Or:
      return integers(in, Integer::OrI);
    case Opcode::Eq:
      return compare(in, Mixed::EqF, Mixed::EqI);
    case Opcode::Neq:
      return compare(in, Mixed::NeqF, Mixed::NeqI);
    case Opcode::Lt:
      return compare(in, Mixed::LtF, Mixed::LtI);
    case Opcode::Le:
      return compare(in, Mixed::LeF, Mixed::LeI);
    case Opcode::Gt:
      return compare(in, Mixed::GtF, Mixed::GtI);
    case Opcode::Ge:
      return compare(in, Mixed::GeF, Mixed::GeI);
    case Opcode::MakeColor:
    case Opcode::MakePoint:
    case Opcode::MakeVector:
    case Opcode::MakeNormal:
    case Opcode::MakeMatrix:
      return construct(in);
    case Opcode::MakeClosure:
      return;  // closures have no value here: patterns give numbers, materials are bxdfs
    case Opcode::Cos:
      return unary(in, Math::Cos, true);
    case Opcode::Sin:
      return unary(in, Math::Sin, true);
    case Opcode::Tan:
      return unary(in, Math::Tan, true);
    case Opcode::SinCos: {
      Instruction half = in;
      half.arguments = {in.arguments[1], in.arguments[0]};
      Instruction other = in;
      other.arguments = {in.arguments[2], in.arguments[0]};
      // the angle may be overwritten by the first result
      if (in.arguments[1] == in.arguments[0]) {
        unary(other, Math::Cos, true);
        return unary(half, Math::Sin, true);
      }
      unary(half, Math::Sin, true);
      return unary(other, Math::Cos, true);
    }
    case Opcode::Acos:
      return unary(in, Math::Acos, true);
    case Opcode::Asin:
      return unary(in, Math::Asin, true);
    case Opcode::Atan:
      return unary(in, Math::Atan, true);
    case Opcode::Atan2:
      return mixed(in, Mixed::Atan2, 1, 2);
    case Opcode::Cosh:
      return unary(in, Math::Cosh, true);
    case Opcode::Sinh:
      return unary(in, Math::Sinh, true);
    case Opcode::Tanh:
      return unary(in, Math::Tanh, true);
    case Opcode::Radians:
      return unary(in, Math::Radians, true);
    case Opcode::Degrees:
      return unary(in, Math::Degrees, true);
    case Opcode::Pow:
      return mixed(in, Mixed::Pow, 1, 2);
    case Opcode::Exp:
      return unary(in, Math::Exp, true);
    case Opcode::Exp2:
      return unary(in, Math::Exp2, true);
    case Opcode::Expm1:
      return unary(in, Math::Expm1, true);
    case Opcode::Log: {
      if (in.arguments.size() == 2) return unary(in, Math::Log, true);
      // log(x) / log(base), each into a value of its own
      const Operand x = number(in.arguments[1]), b = number(in.arguments[2]);
      Operand logs[2];
      const Operand* from[2] = {&x, &b};
      for (int k = 0; k < 2; ++k) {
        logs[k] = temporary(from[k]->base, from[k]->components, from[k]->varies, from[k]->derivs);
        word(from[k]->components);
        resultWords(logs[k], from[k]->derivs);
        if (from[k]->derivs)
          dualWords(*from[k], from[k]->components);
        else
          plainWords(*from[k], from[k]->components);
        emit(variant(Math::Log, from[k]->derivs ? 1 : 0), !from[k]->varies);
      }
      const uint32_t n = uint32_t(componentsOf(base(0)));
      const Target t = begin(in.arguments[0], !x.varies && !b.varies, {x, b});
      const bool dual = t.out.derivs && (x.derivs || b.derivs);
      word(n);
      resultWords(t.out, dual);
      for (const Operand& o : logs) {
        if (dual)
          dualWords(o, n);
        else
          plainWords(o, n);
      }
      emit(variant(Arithmetic::Div, (dual ? 3 : 0) + (t.once ? 0 : !x.varies ? 1 : !b.varies ? 2 : 0)), t.once);
      if (!dual) clearDerivs(t.out, t.once);
      return finish(t);
    }
    case Opcode::Log2:
      return unary(in, Math::Log2, true);
    case Opcode::Log10:
      return unary(in, Math::Log10, true);
    case Opcode::Logb:
      return unary(in, Math::Logb, false);
    case Opcode::Sqrt:
      return unary(in, Math::Sqrt, true);
    case Opcode::InverseSqrt:
      return unary(in, Math::InverseSqrt, true);
    case Opcode::Cbrt:
      return unary(in, Math::Cbrt, true);
    case Opcode::Abs:
    case Opcode::Fabs:
      if (base(0) == Base::Int) return integerUnary(in, Integer::AbsI);
      return unary(in, Math::Abs, true);
    case Opcode::Sign:
      return unary(in, Math::Sign, false);
    case Opcode::Floor:
      return unary(in, Math::Floor, false);
    case Opcode::Ceil:
      return unary(in, Math::Ceil, false);
    case Opcode::Round:
      return unary(in, Math::Round, false);
    case Opcode::Trunc:
      return unary(in, Math::Trunc, false);
    case Opcode::Fmod:
      return mixed(in, Mixed::Fmod, 1, 2);
    case Opcode::Step:
      return mixed(in, Mixed::Step, 1, 2);
    case Opcode::Clamp:
      if (base(0) == Base::Int) {
        Operand lowered =
            temporary(Base::Int, 1, a_.isVarying[size_t(in.arguments[1])] || a_.isVarying[size_t(in.arguments[3])]);
        word(1);
        resultWords(lowered, false);
        mixedWords(operand(in.arguments[1]), 1);
        mixedWords(operand(in.arguments[3]), 1);
        emit(Integer::MinI, !lowered.varies);
        const Operand low = operand(in.arguments[2]);
        const Target t = begin(in.arguments[0], !lowered.varies && !low.varies, {});
        word(1);
        resultWords(t.out, false);
        mixedWords(lowered, 1);
        mixedWords(low, 1);
        emit(Integer::MaxI, t.once);
        return finish(t);
      }
      return mixed(in, Mixed::Clamp, 1, 3);
    case Opcode::Mix:
      if (base(0) == Base::Closure) return;
      return mixed(in, Mixed::Mix, 1, 3);
    case Opcode::Select:
      if (choose(in)) return;
      if (base(3) == Base::Int && operand(in.arguments[3]).components == 1) return mixed(in, Mixed::SelectI, 1, 3);
      return mixed(in, Mixed::Select, 1, 3);
    case Opcode::SmoothStep:
      return mixed(in, Mixed::SmoothStep, 1, 3);
    case Opcode::LinearStep:
      return mixed(in, Mixed::LinearStep, 1, 3);
    case Opcode::SmoothLinearStep:
      return mixed(in, Mixed::SmoothLinearStep, 1, 4);
    case Opcode::IsNan:
      return integerUnary(in, Integer::IsNan);
    case Opcode::IsInf:
      return integerUnary(in, Integer::IsInf);
    case Opcode::IsFinite:
      return integerUnary(in, Integer::IsFinite);
    case Opcode::Erf:
      return unary(in, Math::Erf, true);
    case Opcode::Erfc:
      return unary(in, Math::Erfc, true);
    case Opcode::Cross:
      return vector(in, Vector::Cross, 2, true);
    case Opcode::Dot:
      return vector(in, Vector::Dot, 2, true);
    case Opcode::Length:
      return vector(in, Vector::Length, 1, true);
    case Opcode::Distance:
      return in.arguments.size() == 4 ? vector(in, Vector::SegmentDistance, 3, true)
                                      : vector(in, Vector::Distance, 2, true);
    case Opcode::Normalize:
      return vector(in, Vector::Normalize, 1, true);
    case Opcode::FaceForward:
      return vector(in, Vector::FaceForward, 3, true);
    case Opcode::Reflect:
      return vector(in, Vector::Reflect, 2, true);
    case Opcode::Refract:
      return vector(in, Vector::Refract, 3, true);
    case Opcode::Rotate:
      return vector(in, Vector::Rotate, 3, true);
    case Opcode::Determinant:
    case Opcode::Transpose: {
      const Operand m = asMatrix(operand(in.arguments[1]));
      const Target t = begin(in.arguments[0], !m.varies, {m}, false);
      resultWords(t.out, false);
      reference(m.reg, m.at);
      word(m.varies);
      emit(in.opcode == Opcode::Determinant ? Vector::MatrixDeterminant : Vector::MatrixTranspose, t.once);
      clearDerivs(t.out, t.once);
      return finish(t);
    }
    case Opcode::GetMatrix: {
      const bool two = in.arguments.size() == 4;
      matrixBetween(in, in.arguments[1], two ? in.arguments[2] : kNone);
      return;
    }
    case Opcode::TransformPoint:
      return transform(in, Vector::TransformPoint, false);
    case Opcode::TransformVector:
      return transform(in, Vector::TransformVector, false);
    case Opcode::TransformNormal:
      return transform(in, Vector::TransformNormal, true);
    case Opcode::DerivX:
      return derivative(in, 1);
    case Opcode::DerivY:
      return derivative(in, 2);
    case Opcode::DerivZ:
      return derivative(in, 3);
    case Opcode::FilterWidth:
    case Opcode::Area:
    case Opcode::CalculateNormal:
      return swept(in);
    case Opcode::Noise:
    case Opcode::SNoise:
    case Opcode::PNoise:
    case Opcode::PSNoise:
    case Opcode::CellNoise:
    case Opcode::HashNoise:
    case Opcode::Hash:
      return noise(in);
    case Opcode::Spline:
    case Opcode::SplineInverse:
      return spline(in);
    case Opcode::Luminance:
      return spectral(in, Spectral::Luminance);
    case Opcode::Blackbody:
      return spectral(in, Spectral::Blackbody);
    case Opcode::WavelengthColor:
      return spectral(in, Spectral::WavelengthColor);
    case Opcode::TransformColor: {
      const bool two = in.arguments.size() == 4;
      const std::string *from = two ? constantString(in.arguments[1]) : nullptr,
                        *to = constantString(in.arguments[two ? 2 : 1]);
      if ((two && !from) || !to) return scalar(in, Scalar::Refuse, "a colour space that is not known before the run");
      return transformColor(in, in.arguments[0], number(in.arguments.back()), from, to, false);
    }
    case Opcode::Printf:
      return scalar(in, Scalar::Printf, {}, uint32_t(MessageKind::Printf));
    case Opcode::Error:
      return scalar(in, Scalar::Printf, {}, uint32_t(MessageKind::Error));
    case Opcode::Warning:
      return scalar(in, Scalar::Printf, {}, uint32_t(MessageKind::Warning));
    case Opcode::Fprintf:
      return scalar(in, Scalar::Printf, {}, uint32_t(MessageKind::File));
    case Opcode::Format:
      return scalar(in, Scalar::Format);
    case Opcode::Concat:
      return scalar(in, Scalar::Concat);
    case Opcode::Strlen:
      return scalar(in, Scalar::Strlen);
    case Opcode::GetChar:
      return scalar(in, Scalar::GetChar);
    case Opcode::StartsWith:
      return scalar(in, Scalar::StartsWith);
    case Opcode::EndsWith:
      return scalar(in, Scalar::EndsWith);
    case Opcode::Substr:
      return scalar(in, Scalar::Substr);
    case Opcode::StoI:
      return scalar(in, Scalar::StoI);
    case Opcode::StoF:
      return scalar(in, Scalar::StoF);
    case Opcode::Split:
      return scalar(in, Scalar::Split);
    case Opcode::Complain:
      return scalar(in, Scalar::Printf, {}, uint32_t(MessageKind::Error) | 256);
    case Opcode::ClosureMake:
      return scalar(in, Scalar::ClosureMake);
    case Opcode::ClosureAdd:
      return scalar(in, Scalar::ClosureAdd);
    case Opcode::ClosureMul:
      return scalar(in, Scalar::ClosureMul);
    case Opcode::ClosureText:
      return scalar(in, Scalar::ClosureText);
    case Opcode::DebugNan:
      return scalar(in, Scalar::DebugNan);
    case Opcode::DebugUninit:
      return scalar(in, Scalar::DebugUninit);
    case Opcode::RegexSearch:
      return scalar(in, Scalar::Regex, {}, 0);
    case Opcode::RegexMatch:
      return scalar(in, Scalar::Regex, {}, 1);
    case Opcode::Trace:
      return scalar(in, Scalar::Trace);
    case Opcode::GetMessage:
      return in.arguments.size() == 4
                 ? scalar(in, Scalar::GetMessage)
                 : scalar(in, Scalar::Refuse, "a message of a name that is not known before the run");
    case Opcode::SetMessage:
      return scalar(in, Scalar::Refuse, "a message of a name that is not known before the run");
    case Opcode::DictFind:
      return scalar(in, Scalar::DictFind);
    case Opcode::DictNext:
      return scalar(in, Scalar::DictNext);
    case Opcode::DictValue:
      return scalar(in, Scalar::DictValue);
    case Opcode::GetAttribute:
      return scalar(in, Scalar::GetAttribute);
    case Opcode::RayType:
      return scalar(in, Scalar::RayType);
    case Opcode::Backfacing:
      return scalar(in, Scalar::Backfacing);
    case Opcode::SurfaceArea:
      return scalar(in, Scalar::SurfaceArea);
    case Opcode::Texture:
      return scalar(in, Scalar::Texture, {}, uint32_t(TextureKind::Texture));
    case Opcode::Texture3d:
      return scalar(in, Scalar::Texture, {}, uint32_t(TextureKind::Texture3d));
    case Opcode::Environment:
      return scalar(in, Scalar::Texture, {}, uint32_t(TextureKind::Environment));
    case Opcode::GetTextureInfo:
      return scalar(in, Scalar::GetTextureInfo);
    case Opcode::IsConstant: {
      const bool constant = shader_.symbols[size_t(in.arguments[1])].kind == SymbolKind::Constant;
      return assign(in, in.arguments[0], constantInt(constant));
    }
    default:
      break;
  }
  return scalar(in, Scalar::Refuse, std::string(factsOf(in.opcode).name));
}

}  // namespace kinora::language
