#ifdef __FAST_MATH__
#error "-ffast-math breaks the checks for what is not a number"
#endif
#if FLT_EVAL_METHOD != 0
#error "sums must round to their type at once: for x86 use -mfpmath=sse"
#endif
#if ${mantissa}_MANT_DIG != $digits
#error "$real has other digits than those that the header speaks of"
#endif
