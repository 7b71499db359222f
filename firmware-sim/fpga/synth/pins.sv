// For place and route: the SPI matcher with its wide ports on shift registers, because no package has enough pins.
module pins (
    input  logic clk, spi_clk, rst, s_valid, in, spi_sck, spi_cs_n,
    output logic s_ready, spi_miso, data_ready, out
);
    logic [254:0] i; // ports in
    logic [63:0]  o; // counters out
    logic [15:0]  dropped, unfinished, overfull, out_of_range;

    selfcal_spi_matcher matcher (
        .*, .s_first(i[0]), .s_last(i[1]), .s_keep(i[2]), .s_left_u(i[27:3]), .s_left_v(i[52:28]),
        .s_right_u(i[77:53]), .s_right_v(i[102:78]), .s_score(i[118:103]), .s_level(i[122:119]),
        .timestamp(i[186:123]), .width(i[202:187]), .height(i[218:203]), .grid_step(i[234:219]),
        .fraction_bits(i[238:235]), .pyramid_ratio(i[246:239]));

    always_ff @(posedge clk) begin
        i <= {i[253:0], in};
        o <= i[254] ? {dropped, unfinished, overfull, out_of_range} : {o[62:0], 1'b0};
    end
    assign out = o[63];
endmodule
