// Frames of matches as a stream of bytes: store and reader, with the signals between their clocks.
//
// `clk` is the clock of the matcher, `m_clk` that of the bytes; they are independent, and may be the same
// clock. Hold `rst` for four cycles of the slower one: it empties the framer and restarts the sequence at 0.
module selfcal_framer #(
    parameter int MATCHES = 254
) (
    input  logic         clk,
    input  logic         rst,
    input  logic         s_valid,
    output logic         s_ready,
    input  logic         s_first,
    input  logic         s_last,
    input  logic         s_keep,
    input  logic [24:0]  s_left_u,
    input  logic [24:0]  s_left_v,
    input  logic [24:0]  s_right_u,
    input  logic [24:0]  s_right_v,
    input  logic [15:0]  s_score,
    input  logic [3:0]   s_level,
    input  logic [63:0]  timestamp,
    input  logic [15:0]  width,
    input  logic [15:0]  height,
    input  logic [15:0]  grid_step,
    input  logic [3:0]   fraction_bits,
    input  logic [7:0]   pyramid_ratio,
    output logic [15:0]  dropped,
    output logic [15:0]  unfinished,
    output logic [15:0]  overfull,
    output logic [15:0]  out_of_range,

    input  logic         m_clk,
    output logic         m_rst,
    output logic         m_valid,
    input  logic         m_ready,
    output logic [7:0]   m_data,
    output logic         m_last,
    input  logic         m_begun,
    input  logic         m_missed,
    output logic         m_available
);
    logic waiting, m_waiting, want, s_want, granted, m_granted;
    logic [$clog2(MATCHES+2)-1:0] r_word;
    logic [127:0] r_data;

    selfcal_sync reset_sync   (.clk(m_clk), .rst(1'b0),  .d(rst),     .q(m_rst));
    selfcal_sync waiting_sync (.clk(m_clk), .rst(m_rst), .d(waiting), .q(m_waiting));
    selfcal_sync granted_sync (.clk(m_clk), .rst(m_rst), .d(granted), .q(m_granted));
    selfcal_sync want_sync    (.clk(clk),   .rst(rst),   .d(want),    .q(s_want));

    selfcal_store #(.MATCHES(MATCHES)) store (.*, .want(s_want), .r_clk(m_clk));

    selfcal_reader #(.MATCHES(MATCHES)) reader (
        .clk(m_clk), .rst(m_rst), .waiting(m_waiting), .granted(m_granted), .*);
endmodule
