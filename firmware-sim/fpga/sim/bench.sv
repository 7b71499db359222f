// The framer with all its outputs: `sink` chooses the stream (0), SPI (1) or the UART (2).
module bench #(
    parameter int MATCHES = 30
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
    output logic         m_valid,
    input  logic         m_ready,
    output logic [7:0]   m_data,
    output logic         m_last,
    output logic         m_available,
    input  logic [1:0]   sink,
    input  logic         sck,
    input  logic         cs_n,
    output logic         miso,
    output logic         tx
);
    logic m_rst, ready, begun, missed, spi_ready, spi_begun, spi_missed, uart_ready;

    selfcal_framer #(.MATCHES(MATCHES)) framer (.*, .m_ready(ready), .m_begun(begun), .m_missed(missed));
    selfcal_spi spi (
        .clk(m_clk), .rst(m_rst), .valid(m_valid && sink == 2'd1), .ready(spi_ready), .data(m_data),
        .begun(spi_begun), .missed(spi_missed), .sck(sck), .cs_n(cs_n), .miso(miso));
    selfcal_uart #(.DIVIDER(4)) uart (
        .clk(m_clk), .rst(m_rst), .valid(m_valid && sink == 2'd2), .ready(uart_ready), .data(m_data), .tx(tx));

    always_comb
        case (sink)
            2'd0:    {ready, begun, missed} = {m_ready, 2'b00};
            2'd1:    {ready, begun, missed} = {spi_ready, spi_begun, spi_missed};
            default: {ready, begun, missed} = {uart_ready, 2'b00};
        endcase
endmodule
