#include "builder/texture_encode/kernel_list.h"

namespace cairn::CAIRN_ISA {

const KernelSet kernels = {
    {encode_bc1_fast, encode_bc1_normal, encode_bc1_best},
    {encode_bc1_fast, encode_bc1_normal, encode_bc1_best_four},
    {encode_alpha_fast, encode_alpha_normal, encode_alpha_normal},
    {encode_bc7_fast, encode_bc7_normal, encode_bc7_best},
    bc1_errors,
};

}  // namespace cairn::CAIRN_ISA
