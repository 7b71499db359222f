// The Verilated bench behind three C functions. It is compiled once for each size, with MODEL_HEADER, MODEL and NAME(x)
// defined for that size.
#include MODEL_HEADER

struct Inputs {
    uint64_t timestamp;
    uint32_t coordinates[4];
    uint16_t width, height, grid_step, score;
    uint8_t level, fraction_bits, pyramid_ratio;
    uint8_t clk, rst, s_valid, s_first, s_last, s_keep;
    uint8_t m_clk, m_ready, sink, sck, cs_n;
};

struct Outputs {
    uint16_t dropped, unfinished, overfull, out_of_range;
    uint8_t s_ready, m_valid, m_data, m_last, m_available, miso, tx;
};

extern "C" void *NAME(new)() { return new MODEL; }

extern "C" void NAME(drop)(void *model) { delete static_cast<MODEL *>(model); }

extern "C" void NAME(eval)(void *model, const Inputs *in, Outputs *out)
{
    MODEL &m = *static_cast<MODEL *>(model);
    m.timestamp = in->timestamp;
    m.s_left_u = in->coordinates[0];
    m.s_left_v = in->coordinates[1];
    m.s_right_u = in->coordinates[2];
    m.s_right_v = in->coordinates[3];
    m.width = in->width, m.height = in->height, m.grid_step = in->grid_step;
    m.s_score = in->score, m.s_level = in->level;
    m.fraction_bits = in->fraction_bits, m.pyramid_ratio = in->pyramid_ratio;
    m.clk = in->clk, m.rst = in->rst, m.s_valid = in->s_valid, m.s_first = in->s_first;
    m.s_last = in->s_last, m.s_keep = in->s_keep;
    m.m_clk = in->m_clk, m.m_ready = in->m_ready, m.sink = in->sink, m.sck = in->sck, m.cs_n = in->cs_n;
    m.eval();
    *out = {m.dropped, m.unfinished, m.overfull, m.out_of_range, m.s_ready, m.m_valid, m.m_data,
            m.m_last, m.m_available, m.miso, m.tx};
}
