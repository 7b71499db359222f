// One byte into the CRC-32 of IEEE 802.3, least significant bit first. Combinational.
module selfcal_crc32 (
    input  logic [31:0] crc,
    input  logic [7:0]  data,
    output logic [31:0] next
);
    function automatic logic [31:0] bit_of(input logic [31:0] c);
        bit_of = {1'b0, c[31:1]} ^ (c[0] ? 32'hedb88320 : 32'd0);
    endfunction

    function automatic logic [31:0] four_of(input logic [31:0] c);
        four_of = bit_of(bit_of(bit_of(bit_of(c))));
    endfunction

    assign next = four_of(four_of(crc ^ {24'd0, data}));
endmodule
