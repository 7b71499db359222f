// The framer as an SPI peripheral with a data-ready pin: the module for a matcher.
module selfcal_spi_matcher #(
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

    // Samples the pins, at least eight times as fast as SCK.
    input  logic         spi_clk,
    input  logic         spi_sck,
    input  logic         spi_cs_n,
    output logic         spi_miso,
    output logic         data_ready
);
    logic m_rst, m_valid, m_ready, m_last, m_begun, m_missed;
    logic [7:0] m_data;

    selfcal_framer #(.MATCHES(MATCHES)) framer (.*, .m_clk(spi_clk), .m_available(data_ready));

    selfcal_spi spi (
        .clk(spi_clk), .rst(m_rst), .valid(m_valid), .ready(m_ready), .data(m_data),
        .begun(m_begun), .missed(m_missed), .sck(spi_sck), .cs_n(spi_cs_n), .miso(spi_miso));

    wire unused = m_last;
endmodule
